# SPDX-License-Identifier: GPL-3.0-or-later
"""Painted skin settings of a mesh: factors per vertex, in vertex groups or float attributes.

Their names are `sinew_` and the name of the parameter. The value of an attribute is the factor itself, 0 or more. In a
vertex group the weight is the factor, and vertices outside the group have 0, as everywhere in Blender. If a mesh has both,
the attribute is used.
"""

import numpy as np

from ..errors import SinewError
from .skin_regions import PARAMETERS, Parameter

STORAGES = (
    (
        "VERTEX_GROUP",
        "Vertex Group",
        "A weight from 0 to 1, painted in Weight Paint Mode. Vertices outside the group have 0",
    ),
    (
        "ATTRIBUTE",
        "Attribute",
        "A factor of any size, for Edit Mode (Mesh > Set Attribute), Geometry Nodes and scripts. "
        "It is used instead of a vertex group",
    ),
)


def read(skin) -> dict[str, np.ndarray]:
    """The painted factors of a mesh, (vertices,) float32 each, by the names of the parameters that are painted.

    Raises SinewError if an attribute is not a float per vertex, or has a value below 0 or a value that is not finite.
    """
    mesh = skin.data
    factors, name_of_group = {}, {}
    for parameter in PARAMETERS:
        attribute = _first(mesh.attributes, parameter.painted_names)
        group = _first(skin.vertex_groups, parameter.painted_names)
        if attribute:
            factors[parameter.name] = _read_attribute(skin, attribute)
        elif group:
            name_of_group[group.index] = parameter.name
    if name_of_group:
        factors |= _read_groups(mesh, name_of_group)
    return factors


def _first(named, names: tuple[str, ...]):
    """The item of the first of these names that exists, or None."""
    return next((named[name] for name in names if name in named), None)


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
            f"{skin.name}: attribute '{attribute.name}' is {factors[bad[0]]:g} at vertex {bad[0]}; "
            "make it a number, 0 or more"
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
    """Makes the vertex group or attribute of a parameter active, and creates it if it is missing.

    storage: "VERTEX_GROUP" or "ATTRIBUTE". A new one takes the values of the other storage, which is removed; weights are
    limited to 1. Without those it is 1 everywhere.
    """
    factors = read(skin).get(parameter.name)
    attributes, groups = skin.data.attributes, skin.vertex_groups
    if storage == "ATTRIBUTE":
        if parameter.painted not in attributes:
            # an attribute can't have the name of a vertex group
            _remove_group(skin, parameter)
            _write_attribute(skin.data, parameter, factors)
        attributes.active = attributes[parameter.painted]
        return
    _remove_attribute(skin, parameter)
    if parameter.painted not in groups:
        _write_group(skin, parameter, factors)
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
    for name in parameter.painted_names:
        group = skin.vertex_groups.get(name)
        if group:
            skin.vertex_groups.remove(group)


def _remove_attribute(skin, parameter: Parameter):
    for name in parameter.painted_names:
        attribute = skin.data.attributes.get(name)
        if attribute:
            skin.data.attributes.remove(attribute)


def remove_all(skin):
    """Removes all painted skin settings of a mesh."""
    for parameter in PARAMETERS:
        _remove_attribute(skin, parameter)
        _remove_group(skin, parameter)
