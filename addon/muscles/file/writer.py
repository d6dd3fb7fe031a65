# SPDX-License-Identifier: GPL-3.0-or-later
"""Writing the musculature of a rig to a file."""

import json
import math
from dataclasses import replace
from pathlib import Path

from mathutils import Vector

from ...errors import SinewError
from ...files import strict_json
from ...files.atomic_write import atomic_write
from ...scene import characters, rig_pose, tissue_empty
from ...scene.tissue_empty import TissueShape
from ...settings import bone_settings
from .. import portable_names
from ..bone_space import BoneAxes, RigSegments, axes_of_bone
from .format import FORMAT, GRID_OF_RIG_SIZE, LATER_SKIN_SETTINGS, SKIN_SETTINGS, skins_of
from .reader import Reader

TWIST_STEP_DEG = 0.01


def save(rig, path: Path, problems: dict[str, str]) -> int:
    """Writes the musculature of a rig to a file and returns the number of tissues.

    problems: gets a message for each tissue that can't be read. Raises SinewError if there is no tissue, the file can't be
    written, or `reader.load` would refuse it. An existing file stays as it was until the new one is complete.
    """
    text, count = as_text(rig, problems)
    if len(text.encode()) > strict_json.MAX_FILE_BYTES:
        raise SinewError(
            f"{rig.name} has too many tissues: a musculature file has at most {strict_json.MAX_FILE_BYTES} bytes"
        )
    Reader(rig, strict_json.parse(f"{path.name} was not written", text), problems)
    with atomic_write(path) as file:
        file.write(text.encode())
    return count


def as_text(rig, problems: dict[str, str]) -> tuple[str, int]:
    """The text of a musculature file, and the number of tissues in it. Raises SinewError if there is none."""
    empties = characters.tissues_of(rig)
    if not empties:
        raise SinewError(f"{rig.name} has no muscles to save. Add some (Add Preset, Add Tissue)")
    writer = Writer(rig)
    records = {}
    for name, empty in zip(portable_names.of_tissues(rig, empties), empties, strict=True):
        try:
            shape = replace(tissue_empty.read(empty, rig), name=name)
        except SinewError as error:
            problems[empty.name] = str(error)
            continue
        _check_name("Tissue", name, portable_names.LONGEST_NAME_BYTES)
        records[name] = writer.tissue(shape, empty.sinew.tissue.tension)
    if not records:
        raise SinewError(next(iter(problems.values())))
    lines = ["{", f'  "sinew_musculature": {FORMAT},', f'  "rig": {_json(writer.segments.scheme)},']
    skin = _main_skin(rig)
    if skin:
        lines.append(f'  "skin": {_json(writer.skin(skin))},')
    bones = ",\n".join(f"    {_json(entry)}" for entry in writer.bones())
    if bones:
        lines += ['  "bones": [', bones, "  ],"]
    tissues = ",\n".join(records[name] for name in sorted(records))
    return "\n".join([*lines, '  "tissues": [', tissues, "  ]", "}", ""]), len(records)


class Writer:
    """Converts the tissues and settings of one rig to the contents of a file."""

    def __init__(self, rig):
        self.rig, self.segments = rig, RigSegments(rig)
        self._portable = {empty.name: name for name, empty in portable_names.of_rig(rig).items()}
        self._size = rig_pose.read_rest(rig).size

    def tissue(self, shape: TissueShape, tension: float) -> str:
        """One tissue as a few lines of JSON."""
        origin, insertion = self._at(shape.origin_bone, shape.origin), self._at(shape.insertion_bone, shape.insertion)
        line, length = shape.insertion - shape.origin, (shape.insertion - shape.origin).length
        form = {"widths": [self._rounded(width, length) for width in shape.semi_axes[:2]]}
        axes = axes_of_bone(self.rig, shape.origin_bone)
        form["twist"] = _rounded_twist(axes.twist_deg(shape.rotation @ Vector((1, 0, 0)), line))
        role = self.segments.role_of(shape.origin_bone)
        if role:
            # computed from the rounded values, so that saving a loaded file writes the same numbers again
            line = self._point(shape.insertion_bone, insertion) - self._point(shape.origin_bone, origin)
            x = axes.twisted(form["twist"], line)
            form["twist_in_role"] = _rounded_twist(self.segments.axes_of(role).twist_deg(x, line))
        if shape.kind == "MUSCLE":
            form["tendons"] = [self._rounded(tendon, length) for tendon in (shape.origin_tendon, shape.insertion_tendon)]
            form["volume_keeping"], form["tension"] = _digits(shape.volume_keeping), _digits(tension)
        if shape.skin_thickness:
            form["skin_thickness"] = self._rounded(shape.skin_thickness, length)
        parts = [
            _fields({"name": shape.name, "kind": shape.kind}),
            f'"origin": {_json(self._attachment(shape.origin_bone, origin))}',
            f'"insertion": {_json(self._attachment(shape.insertion_bone, insertion))}',
            _fields(form),
        ]
        if shape.via_points:
            attachments = (self._attachment(bone, self._at(bone, point)) for bone, point in shape.via_points)
            parts.append('"via_points": [\n        ' + ",\n        ".join(map(_json, attachments)) + "]")
        if shape.wraps:
            parts.append(_fields({"wraps": [self._portable[name] for name in shape.wraps]}))
        return "    {" + ",\n     ".join(parts) + "}"

    def skin(self, skin) -> dict:
        """The settings of a mesh. Lengths are fractions of the rig's size."""
        settings = {name: getattr(skin.sinew.skin, name) for name in (*SKIN_SETTINGS, *LATER_SKIN_SETTINGS)}
        settings = {name: _digits(value) if isinstance(value, float) else value for name, value in settings.items()}
        settings["falloff"] = _digits(skin.sinew.skin.falloff / self._size)
        settings["slack"] = _digits(skin.sinew.skin.slack / self._size)
        return settings

    def bones(self) -> list[dict]:
        """The settings of bones that are not 1, in the order of the bones' names."""
        entries = []
        for name, settings in sorted(bone_settings.nondefault(self.rig).items()):
            _check_name("Bone", name, strict_json.MAX_NAME_BYTES)
            role = self.segments.role_of(name)
            values = {setting: _digits(value) for setting, value in settings.items()}
            entries.append({"bone": name} | ({"role": role} if role else {}) | values)
        return entries

    def _at(self, bone: str, point: Vector) -> list[float]:
        """The rounded coordinates of a point of armature space in the axes of a bone."""
        return self._local(axes_of_bone(self.rig, bone), point)

    def _point(self, bone: str, at: list[float]) -> Vector:
        """The point of armature space with these coordinates: the inverse of `_at`."""
        return axes_of_bone(self.rig, bone).to_armature(at)

    def _attachment(self, bone: str, at: list[float]) -> dict:
        _check_name("Bone", bone, strict_json.MAX_NAME_BYTES)
        attachment = {"bone": bone, "at": at}
        role = self.segments.role_of(bone)
        if role:
            at_in_role = self._local(self.segments.axes_of(role), self._point(bone, at))
            attachment |= {"role": role, "at_in_role": at_in_role}
        return attachment

    def _local(self, axes: BoneAxes, point: Vector) -> list[float]:
        return [self._rounded(coordinate * axes.length, axes.length) for coordinate in axes.to_local(point)]

    def _rounded(self, length: float, unit: float) -> float:
        """A length in units, rounded to the grid."""
        step = _round_step(GRID_OF_RIG_SIZE * self._size / unit)
        return _digits(round(length / unit / step) * step)


def _check_name(kind: str, name: str, max_bytes: int):
    """Raises SinewError for a name that a file can't hold."""
    wrong = strict_json.wrong_name(name, max_bytes)
    if wrong:
        raise SinewError(f"{kind} {json.dumps(name, ensure_ascii=False)}: its name {wrong}. Rename it and save again")


def _main_skin(rig):
    """The mesh with the most vertices, or None."""
    return max(skins_of(rig), key=lambda skin: (len(skin.data.vertices), skin.name), default=None)


def _round_step(wanted: float) -> float:
    """The smallest 1, 2 or 5 times a power of ten that is not below `wanted`."""
    power = 10.0 ** math.floor(math.log10(wanted))
    return next(factor * power for factor in (1.0, 2.0, 5.0, 10.0) if factor * power >= wanted * 0.999)


def _rounded_twist(twist_deg: float) -> float:
    twist = _digits(round(twist_deg / TWIST_STEP_DEG) * TWIST_STEP_DEG)
    return 180.0 if twist == -180.0 else twist


def _digits(value: float) -> float:
    """The value rounded to six significant digits; 0 for -0."""
    return float(f"{value:.6g}") + 0.0


def _json(value) -> str:
    return json.dumps(value, ensure_ascii=False)


def _fields(fields: dict) -> str:
    """The fields of an object as JSON, without the braces."""
    return _json(fields)[1:-1]
