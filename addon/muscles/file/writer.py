# SPDX-License-Identifier: GPL-3.0-or-later
"""A rig's musculature as text."""

import json
import math
from dataclasses import replace
from pathlib import Path

from mathutils import Vector

from ...errors import SinewError
from ...files.atomic_write import atomic_write
from ...scene import characters, rig_pose, tissue_empty
from ...scene.tissue_empty import TissueShape
from ...settings import bone_settings
from .. import portable_names
from ..bone_space import Frame, Roles, of_bone
from .format import FORMAT, GRID_OF_RIG_SIZE, LATER_SKIN_SETTINGS, SKIN_SETTINGS, skins_of

TWIST_STEP_DEG = 0.01


def save(rig, path: Path, problems: dict[str, str]) -> int:
    """Writes a rig's musculature to a file and returns the number of tissues; those that can't be read become problems."""
    text, count = as_text(rig, problems)
    with atomic_write(path) as file:
        file.write(text.encode())
    return count


def as_text(rig, problems: dict[str, str]) -> tuple[str, int]:
    """The text of a rig's musculature, and how many tissues it holds."""
    empties = characters.tissues_of(rig)
    if not empties:
        raise SinewError(f"{rig.name} has no muscles to save: add some (Add Muscles, Add Tissue)")
    writer = Writer(rig)
    records = {}
    for empty in empties:
        try:
            name = portable_names.portable_name(empty)
            records[name] = writer.tissue(replace(tissue_empty.read(empty, rig), name=name), empty.sinew.tension)
        except SinewError as error:
            problems[empty.name] = str(error)
    if not records:
        raise SinewError(next(iter(problems.values())))
    lines = ["{", f'  "sinew_musculature": {FORMAT},', f'  "rig": {_json(writer.roles.scheme)},']
    skin = _main_skin(rig)
    if skin:
        lines.append(f'  "skin": {_json(writer.skin(skin))},')
    bones = ",\n".join(f"    {_json(entry)}" for entry in writer.bones())
    if bones:
        lines += ['  "bones": [', bones, "  ],"]
    tissues = ",\n".join(records[name] for name in sorted(records))
    return "\n".join([*lines, '  "tissues": [', tissues, "  ]", "}", ""]), len(records)


class Writer:
    """Tells tissues of one rig from its bones."""

    def __init__(self, rig):
        self.rig, self.roles = rig, Roles(rig)
        self._size = rig_pose.read_rest(rig).size

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
            form["twist_in_role"] = _rounded_twist(
                self.roles.frame(role).twist_deg(frame.twisted(form["twist"], line), line)
            )
        if shape.kind == "MUSCLE":
            form["tendons"] = [self._rounded(tendon, length) for tendon in (shape.origin_tendon, shape.insertion_tendon)]
            form["volume_keeping"], form["tension"] = _digits(shape.volume_keeping), _digits(tension)
        if shape.skin_thickness:
            form["skin_thickness"] = self._rounded(shape.skin_thickness, length)
        parts = [
            _fields({"name": shape.name, "kind": shape.kind}),
            f'"origin": {_json(self._place(shape.origin_bone, origin))}',
            f'"insertion": {_json(self._place(shape.insertion_bone, insertion))}',
            _fields(form),
        ]
        if shape.via_points:
            places = ",\n        ".join(_json(self._place(bone, self._at(bone, point))) for bone, point in shape.via_points)
            parts.append(f'"via_points": [\n        {places}]')
        if shape.wraps:
            parts.append(_fields({"wraps": [self._portable(name) for name in shape.wraps]}))
        return "    {" + ",\n     ".join(parts) + "}"

    def skin(self, skin) -> dict:
        """What a bound mesh is set to; lengths in sizes of the rig."""
        settings = {name: getattr(skin.sinew, name) for name in (*SKIN_SETTINGS, *LATER_SKIN_SETTINGS)}
        settings = {name: _digits(value) if isinstance(value, float) else value for name, value in settings.items()}
        settings["reach"] = _digits(skin.sinew.reach / self._size)
        settings["rest_distance"] = _digits(skin.sinew.rest_distance / self._size)
        return settings

    def bones(self) -> list[dict]:
        """What single bones are set to, other than 1, in the order of their names."""
        entries = []
        for name, settings in sorted(bone_settings.nondefault(self.rig).items()):
            role = self.roles.role_of(name)
            told = {setting: _digits(value) for setting, value in settings.items()}
            entries.append({"bone": name} | ({"role": role} if role else {}) | told)
        return entries

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
        found = portable_names.find(self.rig, tissue)
        return portable_names.portable_name(found) if found else tissue


def _main_skin(rig):
    return max(skins_of(rig), key=lambda skin: (len(skin.data.vertices), skin.name), default=None)


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
