# SPDX-License-Identifier: GPL-3.0-or-later
"""Put a preset's muscles on an armature, bind meshes to them, and save the result as a file."""

import argparse
from pathlib import Path

import bpy

from ..errors import SinewError
from ..muscles.placing.place import placement, preset_file
from ..muscles.placing.place.population import populate
from ..muscles.placing.recognise import segments
from ..operators.base import main_skin_of, writable
from ..skin import binding
from .blend_file import add_file_argument, choose_scene, object_named, open_file, save_copy
from .output import Reporter


def add_arguments(parser: argparse.ArgumentParser):
    add_file_argument(parser)
    parser.add_argument("--armature", metavar="NAME", required=True, help="the armature")
    parser.add_argument(
        "--preset", metavar="NAME", required=True, help="one that Sinew has (human, limbs, cat, myo) or a file"
    )
    parser.add_argument("--bind", metavar="MESH", action="append", default=[], help="a mesh to bind; may be given again")
    parser.add_argument("--save", metavar="OUT", required=True, help="where the result is saved")
    parser.add_argument("--no-fit", action="store_true", help="do not size the muscles by the mesh they lie under")
    parser.add_argument("--scene", metavar="NAME", help="the scene (default: the one that was saved as current)")


def run(wanted: argparse.Namespace, reporter: Reporter) -> dict:
    """Adds, binds and saves; tells how much of it."""
    preset = preset_file.read(wanted.preset)
    open_file(wanted.file, reporter)
    choose_scene(wanted.scene)
    rig = writable(object_named(wanted.armature, "ARMATURE", "armature"))
    skins = [object_named(name, "MESH", "mesh") for name in wanted.bind]
    for skin in skins:
        if binding.check_bindable(skin) != rig:
            raise SinewError(f"{skin.name} follows another armature than {rig.name}")
    body = segments.recognise(rig)
    shapes = populate(rig, preset, body, None if wanted.no_fit else main_skin_of(rig))
    for part, left_out in placement.left_out(preset, body).items():
        reporter.warn(f"{rig.name} has no {part}: {len(left_out)} tissues left out ({left_out[0]}, ...)")
    reporter.say(f"{len(shapes)} tissues added to {rig.name} ({body.scheme})")
    bound = []
    for skin in skins:
        summary = binding.bind(skin, bpy.context.evaluated_depsgraph_get())
        for problem in summary.problems.values():
            reporter.warn(problem)
        reporter.say(f"{skin.name}: {summary.anchored} of {summary.vertices} vertices bound")
        bound.append({"mesh": skin.name, "vertices": summary.vertices, "anchored": summary.anchored})
    save_copy(wanted.save)
    return {
        "verb": "preset",
        "armature": rig.name,
        "scheme": body.scheme,
        "tissues": len(shapes),
        "bound": bound,
        "file": str(Path(wanted.save).absolute()),
    }
