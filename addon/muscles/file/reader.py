# SPDX-License-Identifier: GPL-3.0-or-later
"""A musculature from text, on a rig."""

from dataclasses import dataclass, replace
from pathlib import Path

from mathutils import Vector

from ...errors import SinewError
from ...files import strict_json
from ...scene import bone_geometry, characters, rig_pose, skin_regions
from ...scene.tissue_empty import TissueShape
from ...settings import bone_settings
from .. import edit, portable_names
from ..bone_space import Frame, Roles, of_bone
from ..transfer import spanned
from .format import FORMAT, GRID_OF_RIG_SIZE, LATER_SKIN_SETTINGS, SKIN_SETTINGS, skins_of

LONGEST_NAME_BYTES = 58  # an object's name has 63 bytes, and Blender's ".001" wants room
MOST_TISSUES = 5000
MOST_VIA_POINTS = 100
MOST_BONES = 20_000
FARTHEST = 1e4  # in lengths of the bone
SHORTEST_BELLY = 0.01
KINDS = ("MUSCLE", "BONE", "STUFFING", "SPHERE")


def load(rig, path: Path, replace_all: bool, problems: dict[str, str]) -> list:
    """Gives a rig the musculature of a file; returns the Empties. Tissues whose bones it lacks become problems.

    replace_all: tissues that the file has not are removed, settings of bones that it has not are reset.

    Raises SinewError where the file is faulty or nothing in it fits, and then nothing has been changed.
    """
    reader = Reader(rig, strict_json.read(path), problems)
    if not reader.tissues:
        raise SinewError(next(iter(problems.values()), f"{path.name} holds no tissues"))
    shapes = _without_lost_wraps(rig, [shape for shape, _tension in reader.tissues], replace_all, problems)
    if replace_all:
        names = {shape.name for shape in shapes}
        edit.remove([empty for empty in characters.tissues_of(rig) if portable_names.portable_name(empty) not in names])
    empties = edit.put(rig, [shape for shape in shapes if not shape.wraps])
    # what is wrapped around may have got a number from Blender, so it comes first
    names = {portable_names.portable_name(empty): empty.name for empty in empties}
    wrapped = [replace(shape, wraps=tuple(names.get(name, name) for name in shape.wraps)) for shape in shapes if shape.wraps]
    empties += edit.put(rig, wrapped)
    for shape, tension in reader.tissues:
        portable_names.find(rig, shape.name).sinew.tension = tension
    for skin in skins_of(rig):
        for name, value in reader.skin.items():
            setattr(skin.sinew, name, value)
    if replace_all:
        bone_settings.reset(rig)
    for bone, settings in reader.bones:
        for name, value in settings.items():
            setattr(rig.pose.bones[bone].sinew, name, value)
    return empties


def _without_lost_wraps(rig, shapes: list[TissueShape], replace_all: bool, problems: dict[str, str]) -> list[TissueShape]:
    """The tissues, going round what will be there alone; a sphere that won't becomes a problem of its muscle."""
    spheres = {shape.name for shape in shapes if shape.kind == "SPHERE"}
    if not replace_all:
        names = {shape.name for shape in shapes}
        present = {
            portable_names.portable_name(empty) for empty in characters.tissues_of(rig) if empty.sinew.kind == "SPHERE"
        }
        spheres |= present - names
    for shape in shapes:
        lost = [name for name in shape.wraps if name not in spheres]
        if lost:
            problems[shape.name] = (
                f"{shape.name}: goes round {lost[0]}, which is no sphere of {rig.name}; the wrap is left out"
            )
    return [replace(shape, wraps=tuple(name for name in shape.wraps if name in spheres)) for shape in shapes]


class Reader:
    """A file's tissues and skin settings, as one rig takes them."""

    def __init__(self, rig, table: strict_json.Table, problems: dict[str, str]):
        self._rig, self._roles = rig, Roles(rig)
        if table.get("sinew_musculature") != FORMAT:
            raise table.fault("sinew_musculature", f"must be {FORMAT}: this Sinew reads no other format")
        scheme = table.get("rig")
        if not isinstance(scheme, str):
            raise table.fault("rig", "must be a text, which may be empty")
        self._same_names = scheme == self._roles.scheme
        self.skin = self._skin(table.table("skin")) if table.has("skin") else {}
        self.bones = self._bones(table, problems)
        self.tissues: list[tuple[TissueShape, float]] = []
        names = set()
        entries = table.tables("tissues", MOST_TISSUES)
        table.finish()
        for entry in entries:
            name = entry.text("name", LONGEST_NAME_BYTES)
            if name in names:
                raise entry.fault("name", f"'{name}' stands for two tissues")
            names.add(name)
            found = self._tissue(entry, name, problems)
            if found:
                self.tissues.append(found)

    def _skin(self, table: strict_json.Table) -> dict:
        kinds = self._rig.bl_rna.properties["sinew"].fixed_type.properties
        settings = {}
        for name in (*SKIN_SETTINGS, *(name for name in LATER_SKIN_SETTINGS if table.has(name))):
            known = kinds[name]
            if known.type == "ENUM":
                settings[name] = table.one_of(name, tuple(known.enum_items.keys()))
            elif known.type == "BOOLEAN":
                settings[name] = table.flag(name)
            else:
                value = table.number(name, known.hard_min, known.hard_max)
                settings[name] = round(value) if known.type == "INT" else value
        size = rig_pose.read_rest(self._rig).size
        settings["reach"] = table.number("reach", 0.0, 1e3) * size
        if table.has("rest_distance"):
            settings["rest_distance"] = table.number("rest_distance", 0.0, 1e3) * size
        table.finish()
        return settings

    def _bones(self, table: strict_json.Table, problems: dict[str, str]) -> list[tuple[str, dict[str, float]]]:
        """This rig's bones that the file sets, with what they are set to; a bone that it lacks becomes a problem."""
        kinds = bone_settings.SinewBoneSettings.bl_rna.properties
        found = []
        for entry in table.tables("bones", MOST_BONES) if table.has("bones") else []:
            bone = entry.text("bone")
            role = entry.text("role") if entry.has("role") else ""
            named = [name for name in skin_regions.OF_BONE if entry.has(name)]
            settings = {name: entry.number(name, kinds[name].hard_min, kinds[name].hard_max) for name in named}
            entry.finish()
            has_bone = bone_geometry.has_bone(self._rig, bone)
            # rigs of another kind may call another bone so
            by_role = self._roles.bones_of(role) if role and not (has_bone and self._same_names) else ()
            bones = by_role or ((bone,) if has_bone else ())
            if not bones:
                problems[bone] = f"{self._rig.name} has no bone '{bone}' to give its skin settings to; left out"
            found += [(name, settings) for name in bones]
        return found

    def _tissue(self, table: strict_json.Table, name: str, problems: dict[str, str]):
        """The tissue on this rig, with its tension; None where the rig lacks a bone, which becomes a problem."""
        kind = table.one_of("kind", KINDS)
        origin, insertion = self._place(table.table("origin")), self._place(table.table("insertion"))
        entries = table.tables("via_points", MOST_VIA_POINTS) if table.has("via_points") else []
        via_points = [self._place(entry) for entry in entries]
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
        places = (origin, insertion, *via_points)
        missing = next((place for place in places if not place.bone), None)
        if missing:
            problems[name] = f"{name}: {self._rig.name} has no bone '{missing.wanted}'{missing.in_words}; left out"
            return None
        line = insertion.point - origin.point
        length = line.length
        if length < GRID_OF_RIG_SIZE * bone_geometry.bone_length(self._rig, origin.bone):
            problems[name] = f"{name}: its two ends fall on one point of {self._rig.name}; left out"
            return None
        by_role = origin.by_role and twist_in_role is not None
        shape = spanned(
            origin.point,
            insertion.point,
            x_like=origin.frame.twisted(twist_in_role if by_role else twist, line),
            name=name,
            kind=kind,
            origin_bone=origin.bone,
            insertion_bone=insertion.bone if kind == "MUSCLE" else origin.bone,
            widths=(widths[0] * length, widths[1] * length),
            origin_tendon=tendons[0] * length,
            insertion_tendon=tendons[1] * length,
            volume_keeping=volume_keeping,
            via_points=tuple((place.bone, place.point) for place in via_points),
            wraps=wraps,
            skin_thickness=skin_thickness * length,
        )
        return shape, tension

    def _place(self, table: strict_json.Table) -> "_Place":
        bone = table.text("bone")
        at = table.numbers("at", 3, -FARTHEST, FARTHEST)
        role, at_in_role = "", at
        if table.has("role"):
            role = table.text("role")
            at_in_role = table.numbers("at_in_role", 3, -FARTHEST, FARTHEST)
        table.finish()
        has_bone = bone_geometry.has_bone(self._rig, bone)
        role_frame = self._roles.frame(role) if role else None
        # rigs of another kind may call another bone so, or roll it otherwise
        if role_frame and not (has_bone and self._same_names):
            own = self._roles.bone_at(role, at_in_role[1])
            return _Place(bone, role, own, role_frame, role_frame.from_frame(at_in_role), by_role=True)
        if has_bone:
            frame = of_bone(self._rig, bone)
            return _Place(bone, role, bone, frame, frame.from_frame(at), by_role=False)
        return _Place(bone, role, "", None, None, by_role=False)


@dataclass(frozen=True)
class _Place:
    """Where a point of the file lies on this rig; `bone` is empty where the rig has no such bone."""

    wanted: str
    role: str
    bone: str
    frame: Frame | None
    point: Vector | None
    by_role: bool

    @property
    def in_words(self) -> str:
        """What else was looked for."""
        return f" and no {self.role.replace('_', ' ')}" if self.role else ""
