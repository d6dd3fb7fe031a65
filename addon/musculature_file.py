# SPDX-License-Identifier: GPL-3.0-or-later
"""A musculature as a text file: tissues told from their bones, so that they fit another character, and the skin's settings.

Lengths are fractions: of a bone for the place of a point, of the tissue's own length for its widths and tendons. They
are rounded to a grid that Blender's own precision can hold (4 µm on a man), so that saving what was loaded gives the
same bytes. A file is data: nothing in it is run, and what is wrong with it is told by file, line and field.
"""

import json
import math
import os
from dataclasses import replace
from pathlib import Path

from mathutils import Vector

from . import located_json, mesh_io, musculature, rig_io, roster, tissue_io
from .bone_frames import Frame, Roles, of_bone
from .carrying import spanned
from .errors import SinewError
from .tissue_io import TissueShape

FORMAT = 1
GRID_OF_RIG_SIZE = 2.5e-6
TWIST_STEP_DEG = 0.01
LONGEST_NAME_BYTES = 58  # an object's name has 63 bytes, and Blender's ".001" wants room
MOST_TISSUES = 5000
FARTHEST = 1e4  # in lengths of the bone
KINDS = ("MUSCLE", "BONE", "STUFFING", "SPHERE")
SKIN_SETTINGS = ("anchoring", "carry", "scale_fat", "gain")


def save(rig, path: Path, problems: dict[str, str]) -> int:
    """Writes a rig's musculature to a file and returns the number of tissues; those that can't be read become problems."""
    text, count = as_text(rig, problems)
    unfinished = path.with_name(f"{path.name}.part")
    try:
        unfinished.write_text(text, encoding="utf-8", newline="\n")
        os.replace(unfinished, path)  # an old file is whole until the new one is
    except OSError as error:
        raise SinewError(f"{path}: can't be written ({error.strerror}): choose another folder") from error
    return count


def as_text(rig, problems: dict[str, str]) -> tuple[str, int]:
    """The text of a rig's musculature, and how many tissues it holds."""
    empties = roster.tissues_of(rig)
    if not empties:
        raise SinewError(f"{rig.name} has no muscles to save: add some (Add Muscles, Add Tissue)")
    writer = _Writer(rig)
    records = {}
    for empty in empties:
        try:
            name = musculature.portable_name(empty)
            records[name] = writer.tissue(replace(tissue_io.read(empty, rig), name=name), empty.sinew.tension)
        except SinewError as error:
            problems[empty.name] = str(error)
    lines = ["{", f'  "sinew_musculature": {FORMAT},', f'  "rig": {_json(writer.roles.scheme)},']
    skin = _main_skin(rig)
    if skin:
        lines.append(f'  "skin": {_json(writer.skin(skin))},')
    tissues = ",\n".join(records[name] for name in sorted(records))
    return "\n".join([*lines, '  "tissues": [', tissues, "  ]", "}", ""]), len(records)


class _Writer:
    def __init__(self, rig):
        self.rig, self.roles = rig, Roles(rig)
        self._size = rig_io.read_rest(rig).size

    def tissue(self, shape: TissueShape, tension: float) -> str:
        """One tissue, a few lines."""
        origin, insertion = self._at(shape.origin_bone, shape.origin), self._at(shape.insertion_bone, shape.insertion)
        line, length = shape.insertion - shape.origin, (shape.insertion - shape.origin).length
        form = {"widths": [self._rounded(width, length) for width in shape.semi_axes[:2]]}
        frame = of_bone(self.rig, shape.origin_bone)
        form["twist"] = _rounded_twist(frame.twist_deg(shape.rotation @ Vector((1, 0, 0)), line))
        role = self.roles.role_of(shape.origin_bone)
        if role:
            # what stands in the file twice is told from the rounded values, to be the same after it was loaded
            line = self._point(shape.insertion_bone, insertion) - self._point(shape.origin_bone, origin)
            form["twist_in_role"] = _rounded_twist(self.roles.frame(role).twist_deg(frame.twisted(form["twist"], line), line))
        if shape.kind == "MUSCLE":
            form["tendons"] = [self._rounded(tendon, length) for tendon in (shape.origin_tendon, shape.insertion_tendon)]
            form["volume_keeping"], form["tension"] = _digits(shape.volume_keeping), _digits(tension)
        parts = [
            _fields({"name": shape.name, "kind": shape.kind}),
            f'"origin": {_json(self._place(shape.origin_bone, origin))}',
            f'"insertion": {_json(self._place(shape.insertion_bone, insertion))}',
            _fields(form),
        ]
        if shape.via_points:
            places = ",\n        ".join(
                _json(self._place(bone, self._at(bone, point))) for bone, point in shape.via_points
            )
            parts.append(f'"via_points": [\n        {places}]')
        if shape.wraps:
            parts.append(_fields({"wraps": [self._portable(name) for name in shape.wraps]}))
        return "    {" + ",\n     ".join(parts) + "}"

    def skin(self, skin) -> dict:
        """What a bound mesh is set to; lengths in sizes of the rig."""
        settings = {name: getattr(skin.sinew, name) for name in SKIN_SETTINGS}
        settings["gain"] = _digits(settings["gain"])
        settings["reach"] = _digits(skin.sinew.reach / self._size)
        return settings

    def _at(self, bone: str, point: Vector) -> list[float]:
        return self._in(of_bone(self.rig, bone), point)

    def _point(self, bone: str, at: list[float]) -> Vector:
        return of_bone(self.rig, bone).from_frame(at)

    def _place(self, bone: str, at: list[float]) -> dict:
        place = {"bone": bone, "at": at}
        role = self.roles.role_of(bone)
        if role:
            place |= {"role": role, "at_in_role": self._in(self.roles.frame(role), self._point(bone, at))}
        return place

    def _in(self, frame: Frame, point: Vector) -> list[float]:
        return [self._rounded(part * frame.length, frame.length) for part in frame.to_frame(point)]

    def _rounded(self, length: float, unit: float) -> float:
        """A length in units, on the grid."""
        step = _round_step(GRID_OF_RIG_SIZE * self._size / unit)
        return _digits(round(length / unit / step) * step)

    def _portable(self, tissue: str) -> str:
        found = musculature.find(self.rig, tissue)
        return musculature.portable_name(found) if found else tissue


def load(rig, path: Path, replace_all: bool, problems: dict[str, str]) -> list:
    """Gives a rig the musculature of a file; returns the Empties. Tissues whose bones it lacks become problems.

    Raises SinewError where the file is faulty or nothing in it fits, and then nothing has been changed.
    """
    reader = _Reader(rig, located_json.read(path), problems)
    if not reader.tissues:
        raise SinewError(next(iter(problems.values()), f"{path.name} holds no tissues"))
    shapes = [shape for shape, _tension in reader.tissues]
    if replace_all:
        names = {shape.name for shape in shapes}
        musculature.remove([empty for empty in roster.tissues_of(rig) if musculature.portable_name(empty) not in names])
    empties = musculature.put(rig, [shape for shape in shapes if not shape.wraps])
    # what is wrapped around may have got a number from Blender, so it comes first
    names = {musculature.portable_name(empty): empty.name for empty in empties}
    wrapped = [replace(shape, wraps=tuple(names.get(name, name) for name in shape.wraps)) for shape in shapes if shape.wraps]
    empties += musculature.put(rig, wrapped)
    for shape, tension in reader.tissues:
        musculature.find(rig, shape.name).sinew.tension = tension
    for skin in _skins(rig):
        for name, value in reader.skin.items():
            setattr(skin.sinew, name, value)
    return empties


class _Reader:
    def __init__(self, rig, table: located_json.Table, problems: dict[str, str]):
        self._rig, self._roles = rig, Roles(rig)
        if table.get("sinew_musculature") != FORMAT:
            raise table.fault("sinew_musculature", f"must be {FORMAT}: this Sinew reads no other format")
        scheme = table.get("rig")
        if not isinstance(scheme, str):
            raise table.fault("rig", "must be a text, which may be empty")
        self._same_names = scheme == self._roles.scheme
        self.skin = self._skin(table.table("skin")) if table.has("skin") else {}
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

    def _skin(self, table: located_json.Table) -> dict:
        kinds = self._rig.bl_rna.properties["sinew"].fixed_type.properties
        settings = {}
        for name in SKIN_SETTINGS:
            known = kinds[name]
            if known.type == "ENUM":
                settings[name] = table.one_of(name, tuple(known.enum_items.keys()))
            elif known.type == "BOOLEAN":
                settings[name] = table.flag(name)
            else:
                settings[name] = table.number(name, known.hard_min, known.hard_max)
        settings["reach"] = table.number("reach", 0.0, 1e3) * rig_io.read_rest(self._rig).size
        table.finish()
        return settings

    def _tissue(self, table: located_json.Table, name: str, problems: dict[str, str]):
        """The tissue on this rig, with its tension; None where the rig lacks a bone, which becomes a problem."""
        kind = table.one_of("kind", KINDS)
        origin, insertion = self._place(table.table("origin")), self._place(table.table("insertion"))
        via_points = [self._place(entry) for entry in table.tables("via_points", 100)] if table.has("via_points") else []
        widths = table.numbers("widths", 2, 1e-6, 1e3)
        twist = table.number("twist", -180.0, 180.0)
        twist_in_role = table.number("twist_in_role", -180.0, 180.0) if table.has("twist_in_role") else None
        tendons, volume_keeping, tension = (0.0, 0.0), 1.0, 0.0
        if kind == "MUSCLE":
            tendons = table.numbers("tendons", 2, 0.0, 0.99)
            if sum(tendons) > 0.99:
                raise table.fault("tendons", "leave no belly: together at most 0.99")
            volume_keeping = table.number("volume_keeping", 0.0, 1.5)
            tension = table.number("tension", 0.0, 1.0)
        wraps = table.texts("wraps") if table.has("wraps") else ()
        table.finish()
        places = (origin, insertion, *via_points)
        missing = next((place for place in places if not place.bone), None)
        if missing:
            problems[name] = f"{name}: {self._rig.name} has no bone '{missing.wanted}'{missing.in_words}; left out"
            return None
        line = insertion.point - origin.point
        length = line.length
        if length < GRID_OF_RIG_SIZE * rig_io.bone_length(self._rig, origin.bone):
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
        )
        return shape, tension

    def _place(self, table: located_json.Table) -> "_Place":
        bone = table.text("bone")
        at = table.numbers("at", 3, -FARTHEST, FARTHEST)
        role, at_in_role = "", at
        if table.has("role"):
            role = table.text("role")
            at_in_role = table.numbers("at_in_role", 3, -FARTHEST, FARTHEST)
        table.finish()
        has_bone = rig_io.has_bone(self._rig, bone)
        role_frame = self._roles.frame(role) if role else None
        # rigs of another kind may call another bone so, or roll it otherwise
        if role_frame and not (has_bone and self._same_names):
            own = self._roles.bone_at(role, at_in_role[1])
            return _Place(bone, role, own, role_frame, role_frame.from_frame(at_in_role), by_role=True)
        if has_bone:
            frame = of_bone(self._rig, bone)
            return _Place(bone, role, bone, frame, frame.from_frame(at), by_role=False)
        return _Place(bone, role, "", None, None, by_role=False)


class _Place:
    """Where a point of the file lies on this rig; `bone` is empty where the rig has no such bone."""

    def __init__(self, wanted: str, role: str, bone: str, frame: Frame | None, point: Vector | None, *, by_role: bool):
        self.wanted, self.role, self.bone = wanted, role, bone
        self.frame, self.point, self.by_role = frame, point, by_role

    @property
    def in_words(self) -> str:
        return f" and no {self.role.replace('_', ' ')}" if self.role else ""


def _main_skin(rig):
    return max(_skins(rig), key=lambda skin: (len(skin.data.vertices), skin.name), default=None)


def _skins(rig) -> list:
    """The bound meshes of a rig, or all that follow it where none is bound."""
    skins = roster.skins_of(rig)
    return [skin for skin in skins if mesh_io.is_bound(skin)] or skins


def _round_step(wanted: float) -> float:
    """The next larger one of 1, 2 and 5 times a power of ten."""
    power = 10.0 ** math.floor(math.log10(wanted))
    return next(factor * power for factor in (1.0, 2.0, 5.0, 10.0) if factor * power >= wanted * 0.999)


def _rounded_twist(twist_deg: float) -> float:
    twist = _digits(round(twist_deg / TWIST_STEP_DEG) * TWIST_STEP_DEG)
    return 180.0 if twist == -180.0 else twist


def _digits(value: float) -> float:
    """Six significant digits, and no -0."""
    return float(f"{value:.6g}") + 0.0


def _json(value) -> str:
    return json.dumps(value, ensure_ascii=False)


def _fields(fields: dict) -> str:
    return _json(fields)[1:-1]
