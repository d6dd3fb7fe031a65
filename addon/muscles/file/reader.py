# SPDX-License-Identifier: GPL-3.0-or-later
"""Reading a musculature file and applying it to a rig."""

from dataclasses import dataclass, replace
from pathlib import Path

from mathutils import Vector

from ...errors import SinewError
from ...files import strict_json
from ...scene import bone_geometry, rig_pose
from ...scene.tissue_empty import TissueShape
from ...settings import bone_settings, skin_settings
from .. import edit, portable_names
from ..bone_space import BoneAxes, RigSegments, axes_of_bone
from ..transfer import spanned
from .format import (
    FORMAT,
    FORMAT_0_1,
    FORMER_SKIN_SWITCHES,
    GRID_OF_RIG_SIZE,
    LATER_SKIN_SETTINGS,
    NAMES_0_1,
    SKIN_SETTINGS,
    skins_of,
)

MOST_TISSUES = 5000
MOST_VIA_POINTS = 100
MOST_BONES = 5000
FARTHEST = 1e4  # largest coordinate of a point, in lengths of the bone
SHORTEST_BELLY = 0.01  # as a fraction of the muscle's length
KINDS = ("MUSCLE", "BONE", "STUFFING", "SPHERE")


def load(rig, path: Path, replace_all: bool, problems: dict[str, str]) -> list:
    """Applies a musculature file to a rig and returns the Empties.

    replace_all: removes the tissues that the file lacks, and resets the settings of bones that it lacks. problems: gets a
    message for each tissue or bone of the file that the rig cannot take. Raises SinewError if the file is faulty or no
    tissue of it fits the rig. In that case nothing is changed.
    """
    reader = Reader(rig, strict_json.read(path), problems)
    if not reader.tissues:
        raise SinewError(next(iter(problems.values()), f"{path.name} holds no tissues"))
    shapes = _without_lost_wraps(rig, [shape for shape, _tension in reader.tissues], replace_all, problems)
    if replace_all:
        names_in_file = {shape.name for shape in shapes}
        edit.remove([empty for name, empty in portable_names.of_rig(rig).items() if name not in names_in_file])
    # spheres first, because muscles wrap around them
    shapes.sort(key=lambda shape: bool(shape.wraps))
    empties = edit.add_or_update(rig, shapes)
    tensions = {shape.name: tension for shape, tension in reader.tissues}
    for shape, empty in zip(shapes, empties, strict=True):
        empty.sinew.tissue.tension = tensions[shape.name]
    for skin in skins_of(rig):
        for name, value in reader.skin.items():
            setattr(skin.sinew.skin, name, value)
    if replace_all:
        bone_settings.reset(rig)
    for bone, settings in reader.bones:
        for name, value in settings.items():
            setattr(rig.pose.bones[bone].sinew, name, value)
    return empties


def _without_lost_wraps(rig, shapes: list[TissueShape], replace_all: bool, problems: dict[str, str]) -> list[TissueShape]:
    """The tissues without wraps around spheres that the rig will not have. Each removed wrap becomes a problem."""
    spheres = {shape.name for shape in shapes if shape.kind == "SPHERE"}
    if not replace_all:
        names = {shape.name for shape in shapes}
        named = portable_names.of_rig(rig)
        present = {name for name, empty in named.items() if empty.sinew.tissue.kind == "SPHERE"}
        spheres |= present - names
    for shape in shapes:
        lost = [name for name in shape.wraps if name not in spheres]
        if lost:
            problems[shape.name] = (
                f"{shape.name} wraps around '{lost[0]}', which is not a sphere of {rig.name}; the wrap is left out"
            )
    return [replace(shape, wraps=tuple(name for name in shape.wraps if name in spheres)) for shape in shapes]


class Reader:
    """The contents of a file, converted to one rig.

    tissues: (tissue, tension). skin: settings of the skin by name. bones: (bone name, settings by name).
    """

    def __init__(self, rig, table: strict_json.Table, problems: dict[str, str]):
        """Reads the whole file. Raises SinewError at the first fault, with its line."""
        self._rig, self._segments = rig, RigSegments(rig)
        format_version = table.get("sinew_musculature")
        if format_version not in (FORMAT_0_1, FORMAT):
            supported = f"{FORMAT_0_1} or {FORMAT}"
            raise table.fault("sinew_musculature", f"must be {supported}: this version of Sinew reads no other format")
        self._written_names = NAMES_0_1 if format_version == FORMAT_0_1 else {}
        scheme = table.get("rig")
        if not isinstance(scheme, str):
            raise table.fault("rig", "must be a text, which may be empty")
        self._same_names = scheme == self._segments.scheme
        self.skin = self._skin(table.table("skin")) if table.has("skin") else {}
        self.bones = self._bones(table, problems)
        self.tissues: list[tuple[TissueShape, float]] = []
        names = set()
        entries = table.tables("tissues", MOST_TISSUES)
        table.finish()
        for entry in entries:
            name = entry.text("name", portable_names.LONGEST_NAME_BYTES)
            if name in names:
                raise entry.fault("name", f"'{name}' is the name of two tissues")
            names.add(name)
            entry.describes(name)
            tissue = self._tissue(entry, name, problems)
            if tissue:
                self.tissues.append(tissue)

    def _skin(self, table: strict_json.Table) -> dict:
        kinds = skin_settings.SinewSkinSettings.bl_rna.properties
        settings = {}
        for name in (*SKIN_SETTINGS, *(name for name in LATER_SKIN_SETTINGS if table.has(name))):
            kind, written = kinds[name], self._written(name)
            if kind.type == "ENUM":
                settings[name] = table.one_of(written, tuple(kind.enum_items.keys()))
            elif kind.type == "BOOLEAN":
                settings[name] = table.flag(written)
            else:
                value = table.number(written, kind.hard_min, kind.hard_max)
                settings[name] = round(value) if kind.type == "INT" else value
        size = rig_pose.read_rest(self._rig).size
        settings["falloff"] = table.number(self._written("falloff"), 0.0, 1e3) * size
        if table.has(self._written("slack")):
            settings["slack"] = table.number(self._written("slack"), 0.0, 1e3) * size
        for name in filter(table.has, FORMER_SKIN_SWITCHES):
            table.flag(name)
        table.finish()
        return settings

    def _written(self, name: str) -> str:
        """The name of a setting in this file."""
        return self._written_names.get(name, name)

    def _bones(self, table: strict_json.Table, problems: dict[str, str]) -> list[tuple[str, dict[str, float]]]:
        """The bones of this rig that the file has settings for. A bone that the rig lacks becomes a problem."""
        kinds = bone_settings.SinewBoneSettings.bl_rna.properties
        entries = []
        for entry in table.tables("bones", MOST_BONES) if table.has("bones") else []:
            bone = entry.text("bone")
            role = entry.text("role") if entry.has("role") else ""
            written = {name: self._written(name) for name in bone_settings.STORED}
            settings = {
                name: entry.number(written[name], kinds[name].hard_min, kinds[name].hard_max)
                for name in bone_settings.STORED
                if entry.has(written[name])
            }
            entry.finish()
            has_bone = bone_geometry.has_bone(self._rig, bone)
            # on another kind of rig, the same name can belong to another bone
            by_role = self._segments.bones_of(role) if role and not (has_bone and self._same_names) else ()
            bones = by_role or ((bone,) if has_bone else ())
            if not bones:
                problems[bone] = f"{self._rig.name} has no bone '{bone}' for these skin settings; left out"
            entries += [(name, settings) for name in bones]
        return entries

    def _tissue(self, table: strict_json.Table, name: str, problems: dict[str, str]):
        """The tissue on this rig, with its tension. None if the rig lacks a bone, which becomes a problem."""
        kind = table.one_of("kind", KINDS)
        origin, insertion = self._attachment(table.table("origin")), self._attachment(table.table("insertion"))
        entries = table.tables("via_points", MOST_VIA_POINTS) if table.has("via_points") else []
        via_points = [self._attachment(entry) for entry in entries]
        widths = table.numbers("widths", 2, 1e-6, 1e3)
        twist = table.number("twist", -180.0, 180.0)
        twist_in_role = table.number("twist_in_role", -180.0, 180.0) if table.has("twist_in_role") else None
        tendons, volume_keeping, tension = (0.0, 0.0), 1.0, 0.0
        if kind == "MUSCLE":
            tendons = table.numbers("tendons", 2, 0.0, 1.0)
            if sum(tendons) > 1.0 - SHORTEST_BELLY:
                raise table.fault("tendons", f"leave no belly: together at most {1.0 - SHORTEST_BELLY:g}")
            volume_keeping = table.number("volume_keeping", 0.0, 1.5)
            tension = table.number("tension", 0.0, 1.0)
        wraps = table.texts("wraps") if table.has("wraps") else ()
        skin_thickness = table.number("skin_thickness", 0.0, 1e3) if table.has("skin_thickness") else 0.0
        table.finish()
        attachments = (origin, insertion, *via_points)
        missing = next((attachment for attachment in attachments if not attachment.bone), None)
        if missing:
            problems[name] = f"{name}: {self._rig.name} has no bone '{missing.bone_in_file}'{missing.and_no_role}; left out"
            return None
        line = insertion.point - origin.point
        length = line.length
        if length < GRID_OF_RIG_SIZE * bone_geometry.bone_length(self._rig, origin.bone):
            problems[name] = f"{name}: its two ends are the same point on {self._rig.name}; left out"
            return None
        by_role = origin.by_role and twist_in_role is not None
        shape = spanned(
            origin.point,
            insertion.point,
            x_like=origin.axes.twisted(twist_in_role if by_role else twist, line),
            name=name,
            kind=kind,
            origin_bone=origin.bone,
            insertion_bone=insertion.bone if kind == "MUSCLE" else origin.bone,
            widths=(widths[0] * length, widths[1] * length),
            origin_tendon=tendons[0] * length,
            insertion_tendon=tendons[1] * length,
            volume_keeping=volume_keeping,
            via_points=tuple((via.bone, via.point) for via in via_points),
            wraps=wraps,
            skin_thickness=skin_thickness * length,
        )
        return shape, tension

    def _attachment(self, table: strict_json.Table) -> "_Attachment":
        bone = table.text("bone")
        at = table.numbers("at", 3, -FARTHEST, FARTHEST)
        role, at_in_role = "", at
        if table.has("role"):
            role = table.text("role")
            at_in_role = table.numbers("at_in_role", 3, -FARTHEST, FARTHEST)
        table.finish()
        has_bone = bone_geometry.has_bone(self._rig, bone)
        role_axes = self._segments.axes_of(role) if role else None
        # on another kind of rig, the same name can belong to another bone or to a bone with another roll
        if role_axes and not (has_bone and self._same_names):
            bone_of_role = self._segments.bone_at(role, at_in_role[1])
            return _Attachment(bone, role, bone_of_role, role_axes, role_axes.to_armature(at_in_role), by_role=True)
        if has_bone:
            axes = axes_of_bone(self._rig, bone)
            return _Attachment(bone, role, bone, axes, axes.to_armature(at), by_role=False)
        return _Attachment(bone, role, "", None, None, by_role=False)


@dataclass(frozen=True)
class _Attachment:
    """A point of the file on this rig, armature space. bone, axes and point are empty if the rig has no such bone."""

    bone_in_file: str
    role: str
    bone: str
    axes: BoneAxes | None
    point: Vector | None
    by_role: bool

    @property
    def and_no_role(self) -> str:
        """The rest of an error message: the role that was not found either."""
        return f" and no {self.role.replace('_', ' ')}" if self.role else ""
