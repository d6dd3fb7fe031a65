# SPDX-License-Identifier: GPL-3.0-or-later
"""Base classes of the operators, which report errors, and the objects that an operator's context selects."""

import math
from pathlib import Path

import bpy

from ..display import views
from ..errors import SinewError
from ..languages.messages import translated
from ..muscles import muscle_path
from ..scene import armature_modifier, characters, live_switch, stored_settings
from ..settings import preferences


class Translated:
    """Mix-in before `Operator`: reports, and the reasons why an operator is greyed out, are in the user's language."""

    def report(self, kinds: set[str], message: str):
        super().report(kinds, translated(message))

    @classmethod
    def poll_message_set(cls, message: str):
        super().poll_message_set(translated(message))


class SinewOperator(Translated):
    """Mix-in: `run` does the work and returns the text to report. A SinewError becomes an error report.

    needs_tissues, needs_bound_skin: what the character must have. Without it the operator is greyed out, with a reason.
    """

    bl_options = {"REGISTER", "UNDO"}
    needs_tissues = needs_bound_skin = False

    @classmethod
    def poll(cls, context):
        if context.object is None:
            cls.poll_message_set("Select an armature, its mesh or one of its muscles")
            return False
        if context.object.type not in ("ARMATURE", "MESH") and _armature_of_empty(context.object) is None:
            cls.poll_message_set(_without_armature(context.object))
            return False
        if context.object.mode == "EDIT":
            cls.poll_message_set("Leave Edit Mode first (Tab)")
            return False
        if cls.needs_tissues or cls.needs_bound_skin:
            missing = _missing(context, cls.needs_tissues, cls.needs_bound_skin)
            if missing:
                cls.poll_message_set(missing)
                return False
        return True

    def execute(self, context):
        rig = rig_or_none(context)
        had_tissues = rig is not None and has_tissues(rig)
        try:
            require_numbers(self)
            message = self.run(context)
        except SinewError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        if rig is not None:
            show_changed(rig, context, is_first=not had_tissues and has_tissues(rig))
        if message:
            self.report({"INFO"}, message)
        return {"FINISHED"}

    def warn(self, problems: dict[str, str]):
        """Reports tissues that were left out, with their reasons. problems: reason by name."""
        for problem in problems.values():
            self.report({"WARNING"}, problem)


def _missing(context, needs_tissues: bool, needs_bound_skin: bool) -> str:
    """What the context's character is without and what to do, or an empty text. Costs little, because panels call it."""
    try:
        rig = rig_of_context(context)
    except SinewError as error:
        return str(error)
    character = characters.character_of(rig)
    if needs_tissues and not (character and character.tissues):
        return f"{rig.name} has no muscles. Add some with Add Preset or Add Tissue"
    if needs_bound_skin and not (character and character.skins):
        return f"The skin of {rig.name} is not bound. Bind it first (Bind Skin)"
    return ""


LARGEST_NUMBER = 1e18  # that the core takes: its square is a number in single precision


def require_numbers(operator):
    """Raises SinewError if a property that a script set is not a finite number, or too large for the core."""
    for found in operator.rna_type.properties:
        if found.type == "FLOAT":
            value = getattr(operator, found.identifier)
            values = tuple(value) if found.is_array else (value,)
            if max(map(abs, values)) > LARGEST_NUMBER:
                raise SinewError(f"{found.name} is too large: {found.identifier}={value}. Set a number up to 1e18")
            if not all(map(math.isfinite, values)):
                raise SinewError(f"{found.name} is not a number: {found.identifier}={value}. Set a finite number")


def chosen_file(filepath: str) -> Path:
    """The path that the property of an operator names. Raises SinewError if it has no file name."""
    if filepath.startswith("//") and not bpy.data.filepath:
        raise SinewError(
            "The file is not saved, so // is not a folder yet. Save the file, or choose a full path and file name"
        )
    path = Path(bpy.path.abspath(filepath))
    if not path.name or filepath.endswith(("/", "\\")):
        raise SinewError(f"'{filepath}' has no file name. Choose a folder and a file name")
    return path


class PoseModeOperator(SinewOperator):
    """Mix-in for an operator on bones in Pose Mode."""

    @classmethod
    def poll(cls, context):
        if context.object is None or context.object.type != "ARMATURE" or context.object.mode != "POSE":
            cls.poll_message_set("Select an armature and enter Pose Mode (Ctrl+Tab)")
            return False
        return True


class MuscleOperator(SinewOperator):
    """Mix-in for an operator on the active muscle, or on the muscle of the active via point."""

    @classmethod
    def poll(cls, context):
        if not super().poll(context):
            return False
        try:
            muscle_path.muscle_of(context.object)
        except SinewError as error:
            cls.poll_message_set(str(error))
            return False
        return True


def rig_of_context(context):
    """The active armature, or the armature of the active mesh, tissue or goal. Raises SinewError if there is none."""
    active = context.object
    if active is None:
        raise SinewError("Select an armature, its mesh or one of its muscles")
    if active.type == "ARMATURE":
        return active
    if active.type == "MESH":
        return armature_modifier.rig_of(active)
    rig = _armature_of_empty(active)
    if rig is None:
        raise SinewError(_without_armature(active))
    return rig


def rig_or_none(context):
    """The context's armature (`rig_of_context`), or None."""
    try:
        return rig_of_context(context)
    except SinewError:
        return None  # polls and panels treat a missing armature as a state, not as an error


def has_tissues(rig) -> bool:
    """Whether a rig has at least one tissue."""
    character = characters.character_of(rig)
    return character is not None and bool(character.tissues)


def is_in_window() -> bool:
    """Whether a person sees what an operator does."""
    return not bpy.app.background


def show_changed(rig, context, is_first: bool):
    """Shows the view of a rig again, because an operator may have added meshes.

    is_first: the operator added the first tissues. In a window the view then becomes X-ray, so that they are seen, and only
    the chosen tissue shows its Empty.
    """
    stored = preferences.current()
    is_wanted = is_first and is_in_window() and (stored is None or stored.shows_first)
    if is_wanted and views.of(rig) == views.SKIN and not rig.library:
        rig.sinew.rig.show_empties = False
        rig.sinew.rig.view = views.XRAY
    elif views.of(rig) != views.SKIN:
        views.apply(rig, context.view_layer)


def active_bone(context):
    """The active pose bone of the context's armature (`rig_of_context`), or None."""
    rig = rig_or_none(context)
    if rig is None:
        return None
    active = rig.data.bones.active
    return rig.pose.bones.get(active.name) if active and rig.pose else None


def _armature_of_empty(empty):
    if empty.parent and empty.parent.type == "ARMATURE":
        return empty.parent
    return stored_settings.rig_of_goal(empty)


def _without_armature(empty) -> str:
    return f"{empty.name} does not belong to an armature. Select an armature, its mesh or one of its muscles"


def writable_muscle(context):
    """The active muscle, or the muscle of the active via point. Raises SinewError if it is linked from another file."""
    muscle = muscle_path.muscle_of(context.object)
    if muscle.library:
        raise SinewError(f"{muscle.name} is linked from another file. Make a library override of its armature first")
    return muscle


def skins_of_context(context) -> list:
    """The active and selected meshes, or all meshes of the active armature. Raises SinewError if there is none."""
    active = context.object
    if active and active.type == "MESH":
        return list(dict.fromkeys((active, *(mesh for mesh in context.selected_objects if mesh.type == "MESH"))))
    rig = rig_of_context(context)
    skins = characters.skins_of(rig)
    if not skins:
        raise SinewError(f"{rig.name} has no mesh. Select a mesh, parent it to {rig.name} (Ctrl+P) and try again")
    return skins


def skins_to_bake(context) -> list:
    """The skins of the context. For an armature only its bound meshes, or all meshes if none is bound."""
    skins = skins_of_context(context)
    if context.object.type == "MESH":
        return skins
    return [skin for skin in skins if armature_modifier.is_bound(skin)] or skins


def skins_for_keys(context) -> list:
    """The skins to bake. Raises SinewError if one of them plays a point cache, which would hide its keys."""
    skins = skins_to_bake(context)
    for skin in skins:
        if armature_modifier.is_bound(skin) and live_switch.cache_modifier_of(skin):
            raise SinewError(
                f"{skin.name} plays a point cache, which would hide the keys. Remove its Mesh Cache modifier first"
            )
    return skins
