"""Adds muscles to each character of a list of files and prints what was recognized as a Markdown table.

usage: python3 scripts/run_in_blender.py scripts/benchmarks/recognition_table.py [--preset NAME] [--bones] [--worse FILE]
FILE...

FILE is a .glb, .gltf, .vrm, .fbx or .blend file with a rigged character. Without --preset the muscles are those that Add
Muscles chooses. --bones also lists the bones of each body part below the table. --worse: a JSON file with the number of
poses worse, by file name, for the last column. The exit code is 1 if a file gave a traceback.
"""

import argparse
import contextlib
import json
import os
import re
import sys
import tempfile
from pathlib import Path

import bpy
from bl_ext.user_default.sinew.errors import SinewError
from bl_ext.user_default.sinew.muscles.placing.recognise import choice, kind, recognition

HEADER = (
    "| file | kind found | sure | rig | muscles of | muscles | left out | poses worse | message |\n"
    "|---|---|---|---|---|---|---|---|---|"
)


def load(path: Path):
    """Opens or imports a file. Returns the armature of its largest skinned mesh, or the first armature. None without one."""
    suffix = path.suffix.lower()
    if suffix == ".blend":
        bpy.ops.wm.open_mainfile(filepath=str(path))
    else:
        bpy.ops.wm.read_homefile(use_empty=True)
        if suffix == ".fbx":
            bpy.ops.import_scene.fbx(filepath=str(path))
        else:
            bpy.ops.import_scene.gltf(filepath=str(path), merge_vertices=True, disable_bone_shape=True)
    meshes = [found for found in bpy.context.view_layer.objects if found.type == "MESH" and _rig_of(found)]
    if meshes:
        return _rig_of(max(meshes, key=lambda mesh: len(mesh.data.vertices)))
    return next((found for found in bpy.context.view_layer.objects if found.type == "ARMATURE"), None)


def _rig_of(mesh):
    return next((modifier.object for modifier in mesh.modifiers if modifier.type == "ARMATURE" and modifier.object), None)


@contextlib.contextmanager
def captured(lines: list[str]):
    """Appends what Blender and Python print to `lines`. Blender prints from C, so the file descriptors are replaced."""
    sys.stdout.flush()
    sys.stderr.flush()
    kept = [os.dup(1), os.dup(2)]
    with tempfile.TemporaryFile("w+") as printed:
        os.dup2(printed.fileno(), 1)
        os.dup2(printed.fileno(), 2)
        try:
            yield
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            for descriptor, copy in zip((1, 2), kept, strict=True):
                os.dup2(copy, descriptor)
                os.close(copy)
            printed.seek(0)
            lines += printed.read().splitlines()


def row_of(rig, preset: str) -> tuple[str, ...]:
    """The kind and how sure it is, the kind of rig, the preset, the muscles, the tissues left out, and the report."""
    if bpy.context.object and bpy.context.object.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    for found in bpy.context.view_layer.objects:
        found.select_set(False)
    rig.hide_set(False)
    bpy.context.view_layer.objects.active = rig
    creature = kind.kind_of_character(rig)
    sure = f"{min(round(100 * creature.sureness), 99)} %"
    lines: list[str] = []
    try:
        with captured(lines):
            if preset:
                bpy.ops.sinew.add_preset(name=preset)
            else:
                bpy.ops.sinew.add_muscles()
    except RuntimeError as error:
        text = str(error).strip()
        message = "TRACEBACK" if "Traceback" in text else f"refused: {text.removeprefix('Error: ')}"
        return creature.name, sure, "-", preset or "-", "0", "-", message
    muscles = sum(found.sinew.tissue.kind == "MUSCLE" for found in bpy.data.objects)
    report = "\n".join(lines)
    left_out = re.search(r"; (\d+) tissues left out (\(.*\))", report)
    warnings = [line.partition(": ")[2] for line in lines if line.startswith("Warning: ")]
    chosen = preset or ("each joint" if " joints" in report else choice.preset_of(creature.name))
    try:
        label = recognition.recognise(rig, kind=creature.name).label
    except SinewError:
        label = "-"
    gone = " ".join(left_out.groups()) if left_out else "-"
    return creature.name, sure, label, chosen, str(muscles), gone, "; ".join(warnings) or "-"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--preset", default="", help="the preset to add (default: what Add Muscles chooses)")
    parser.add_argument("--worse", type=Path, help="a JSON file with the number of poses worse, by file name")
    parser.add_argument("--bones", action="store_true", help="list the bones of each body part")
    parser.add_argument("files", metavar="FILE", nargs="+", type=Path)
    wanted = parser.parse_args(sys.argv[1:])
    worse = json.loads(wanted.worse.read_text(encoding="utf-8")) if wanted.worse else {}
    rows, bones = [], []
    for path in wanted.files:
        with captured([]):
            rig = load(path)
        row = row_of(rig, wanted.preset) if rig else (*["-"] * 6, "the file has no armature")
        rows.append((path.name, *row[:-1], str(worse.get(path.name, "")), row[-1]))
        if wanted.bones and rig:
            with contextlib.suppress(SinewError):
                chains = recognition.recognise(rig, kind=kind.kind_of_character(rig).name).chains
                bones.append(f"{path.name}: " + ", ".join(f"{r} {s}={'+'.join(b)}" for (r, s), b in chains.items()))
    print(HEADER)
    for row in rows:
        print("| " + " | ".join(row) + " |")
    print("\n".join(bones))
    return int(any(row[-1] == "TRACEBACK" for row in rows))


if __name__ == "__main__":
    sys.exit(main())
