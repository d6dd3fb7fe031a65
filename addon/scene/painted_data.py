# SPDX-License-Identifier: GPL-3.0-or-later
"""The only reader and writer of what a person paints for Sinew on a mesh: vertex groups or float attributes.

They are named `sinew_` and the parameter. An attribute's value is the factor itself, 0 or more; of a vertex group it is
the weight, and a vertex outside the group counts as weight 0, as it does everywhere in Blender. Where both are there the
attribute counts.
"""

import numpy as np

from ..errors import SinewError
from .skin_regions import PARAMETERS, Parameter

STORAGES = (
    (
        "VERTEX_GROUP",
        "Vertex Group",
        "A weight 0..1, painted in Weight Paint Mode; a vertex outside the group counts as 0",
    ),
    (
        "ATTRIBUTE",
        "Attribute",
        "A factor of any size, for Edit Mode (Mesh > Set Attribute), Geometry Nodes and scripts; it goes before a vertex group",
    ),
)


def read(skin) -> dict[str, np.ndarray]:
    """(vertices,) float32 each: the painted factors of a mesh by parameter; none for what is not painted.

    Raises SinewError where an attribute can't be a factor.
    """
    mesh = skin.data
    factors, name_of_group = {}, {}
    for parameter in PARAMETERS:
        attribute = mesh.attributes.get(parameter.painted)
        group = skin.vertex_groups.get(parameter.painted)
        if attribute:
            factors[parameter.name] = _read_attribute(skin, attribute)
        elif group:
            name_of_group[group.index] = parameter.name
    if name_of_group:
        factors |= _read_groups(mesh, name_of_group)
    return factors


def _read_attribute(skin, attribute) -> np.ndarray:
    if attribute.domain != "POINT" or attribute.data_type != "FLOAT":
        raise SinewError(
            f"{skin.name}: attribute '{attribute.name}' is not a float per vertex: convert it "
            "(Attributes > Convert Attribute: Vertex, Float), remove or rename it"
        )
    factors = np.empty(len(attribute.data), np.float32)
    attribute.data.foreach_get("value", factors)
    bad = np.flatnonzero(~(np.isfinite(factors) & (factors >= 0.0)))
    if len(bad):
        raise SinewError(
            f"{skin.name}: attribute '{attribute.name}' is {factors[bad[0]]:g} at vertex {bad[0]}; make it a number, 0 or more"
        )
    return factors


def _read_groups(mesh, name_of_group: dict[int, str]) -> dict[str, np.ndarray]:
    factors = {name: np.zeros(len(mesh.vertices), np.float32) for name in name_of_group.values()}
    for vertex in mesh.vertices:
        for element in vertex.groups:
            name = name_of_group.get(element.group)
            if name:
                factors[name][vertex.index] = element.weight
    return factors


def make(skin, parameter: Parameter, storage: str):
    """Gives a mesh the group or attribute to paint a parameter in, 1 everywhere, and makes it the active one.

    What is there stays; what is there in the other storage moves over (a weight is at most 1).
    """
    painted = read(skin).get(parameter.name)
    attributes, groups = skin.data.attributes, skin.vertex_groups
    if storage == "ATTRIBUTE":
        if parameter.painted not in attributes:
            # Blender gives no attribute the name of a vertex group
            _remove_group(skin, parameter)
            _write_attribute(skin.data, parameter, painted)
        attributes.active = attributes[parameter.painted]
        return
    _remove_attribute(skin, parameter)
    if parameter.painted not in groups:
        _write_group(skin, parameter, painted)
    groups.active = groups[parameter.painted]


def _write_attribute(mesh, parameter: Parameter, factors: np.ndarray | None):
    data = mesh.attributes.new(parameter.painted, "FLOAT", "POINT").data
    data.foreach_set("value", np.ones(len(data), np.float32) if factors is None else factors)
    mesh.update_tag()


def _write_group(skin, parameter: Parameter, factors: np.ndarray | None):
    group = skin.vertex_groups.new(name=parameter.painted)
    if factors is None:
        group.add(range(len(skin.data.vertices)), 1.0, "REPLACE")
        return
    for vertex, factor in enumerate(np.minimum(factors, 1.0).tolist()):
        group.add((vertex,), factor, "REPLACE")


def _remove_group(skin, parameter: Parameter):
    group = skin.vertex_groups.get(parameter.painted)
    if group:
        skin.vertex_groups.remove(group)


def _remove_attribute(skin, parameter: Parameter):
    attribute = skin.data.attributes.get(parameter.painted)
    if attribute:
        skin.data.attributes.remove(attribute)


def remove_all(skin):
    """Takes all that was painted for Sinew off a mesh."""
    for parameter in PARAMETERS:
        _remove_attribute(skin, parameter)
        _remove_group(skin, parameter)
