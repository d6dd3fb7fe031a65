# SPDX-License-Identifier: GPL-3.0-or-later
"""Binds meshes to the tissues of their rig, and unbinds them."""

from dataclasses import dataclass

from ..display import edge_stretch_colours
from ..errors import SinewError
from ..live import frame, garments, session
from ..scene import armature_modifier, characters, correction_modifier, modifier_stack, rest_body, stored_settings
from ..settings import bone_settings
from . import layers

SMALLEST_DETERMINANT = 1e-18  # of the scale of a mesh or an armature


@dataclass(frozen=True)
class BindSummary:
    """The result of a bind. problems: the tissues that could not be used, each with the reason."""

    vertices: int
    anchored: int
    tissues: int
    problems: dict[str, str]


def bind(skin, depsgraph) -> BindSummary:
    """Binds a mesh in the rest pose and makes it live. Raises SinewError, and leaves the file as it was."""
    summaries, refused = bind_all([skin], depsgraph)
    if refused:
        raise SinewError(refused[skin.name])
    return summaries[skin.name]


def bind_all(skins: list, depsgraph) -> tuple[dict[str, BindSummary], dict[str, str]]:
    """Binds meshes in the rest pose and makes them live. Returns summaries, and the reasons for meshes that can't be bound.

    Both are by name. A mesh that can't be bound is as before. A mesh that is bound for the first time and is worn over
    another bound one becomes a garment.
    """
    summaries, refused = {}, {}
    under = _layers_of(skins)
    for skin in sorted(skins, key=lambda skin: _depth(skin, under)):
        body = under.get(skin)
        try:
            summaries[skin.name] = _bind(skin, body if body and armature_modifier.is_bound(body) else None, depsgraph)
        except SinewError as error:
            refused[skin.name] = str(error)
    if summaries:
        frame.frame(depsgraph)
    return summaries, refused


def _layers_of(skins: list) -> dict:
    """The mesh that each mesh is worn over, among these meshes and those of their rigs that are bound."""
    under: dict = {}
    for rig in dict.fromkeys(filter(None, map(characters.rig_or_none, skins))):
        meshes = [skin for skin in characters.skins_of(rig) if skin in skins or armature_modifier.is_bound(skin)]
        under |= layers.under_each(rig, meshes)
    return under


def _depth(skin, under: dict) -> int:
    """How many meshes are under a mesh. A circle, which the user can choose, ends the count."""
    depth = 0
    while skin in under and depth <= len(under):
        skin, depth = under[skin], depth + 1
    return depth


def _bind(skin, body, depsgraph) -> BindSummary:
    """Binds a mesh. The next frame shows it. body: the bound mesh that it is worn over, or None."""
    rig = check_bindable(skin)
    settings = skin.sinew.skin
    before, reason = session.cached_skin(skin), session.reason(skin)
    settings_before = settings.body_keys, stored_settings.worn_over_of(skin)
    _wear_over(skin, body)
    settings.body_keys = "\n".join(name for name, _value in rest_body.shown_keys(skin))
    session.forget_skin(skin)
    try:
        rig_state = session.rig_state(rig, characters.tissues_of(rig), depsgraph)
        state = garments.skin_state(depsgraph, rig, skin, rig_state)
    except (SinewError, ValueError) as error:
        settings.body_keys = settings_before[0]
        _wear_over(skin, settings_before[1])
        if before:
            session.pin_bind(skin, before)
        session.set_reason(skin, reason)
        raise SinewError(str(error) if isinstance(error, SinewError) else f"{skin.name}: {error}") from error
    correction_modifier.add_correction(skin, modifier_stack.position(skin))
    bone_settings.prepare(rig)
    settings.bound = settings.live = True
    characters.forget()
    return BindSummary(len(state.points), state.skin.anchored, len(rig_state.tension), dict(rig_state.problems))


def _wear_over(skin, body):
    if stored_settings.worn_over_of(skin) != body:
        skin.sinew.skin.worn_over = body


def check_bindable(skin):
    """The rig of a mesh. Raises SinewError, with what to do, if the mesh can't be bound."""
    if skin.type != "MESH":
        raise SinewError(f"{skin.name} is a {skin.type.lower()}, not a mesh. Select the character's mesh")
    if skin.library or skin.data.library:
        raise SinewError(
            f"{skin.name} is linked from another file and can't be changed. Make it local "
            "(Object > Relations > Make Local > Selected Objects and Data) or bind it in its own file"
        )
    if not skin.data.vertices:
        raise SinewError(f"{skin.name} has no vertices")
    if skin.data.is_editmode:
        raise SinewError(f"{skin.name} is in Edit Mode. Leave it (Tab) and bind again")
    rig = armature_modifier.rig_of(skin)
    if rig.data.is_editmode:
        raise SinewError(f"{rig.name} is in Edit Mode. Leave it (Tab) and bind again")
    if skin.parent == rig and skin.parent_type == "BONE":
        raise SinewError(f"{skin.name} is parented to a bone. Parent it to the armature {rig.name} itself")
    keys = skin.data.shape_keys
    if keys and not keys.use_relative:
        raise SinewError(f"{skin.name} has absolute shape keys, which Sinew does not support. Make them relative")
    for scaled in (skin, rig):
        if abs(scaled.matrix_world.determinant()) < SMALLEST_DETERMINANT:
            raise SinewError(f"{scaled.name} has a scale of 0. Set a scale above 0")
    others = [
        other.name
        for other in characters.skins_of_mesh(skin.data)
        if other != skin and armature_modifier.is_bound(other) and characters.rig_or_none(other) not in (None, rig)
    ]
    if others:
        raise SinewError(
            f"{skin.name} shares its mesh with {', '.join(others)} on another armature. Make it a single user "
            "(Object > Relations > Make Single User > Object & Data)"
        )
    armature_modifier.skinning_of(skin)
    modifier_stack.check(skin)
    return rig


def unbind(skin):
    """Removes the correction from a mesh, which is then as before the bind. The tissues stay."""
    session.forget_skin(skin)
    skin.sinew.skin.live = False  # baked keys act again
    correction_modifier.remove_correction(skin)
    edge_stretch_colours.remove(skin.data)
    skin.sinew.skin.bound = False
    skin.sinew.skin.property_unset("body_keys")
    skin.sinew.skin.property_unset("worn_over")
    characters.forget()
