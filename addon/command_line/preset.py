# SPDX-License-Identifier: GPL-3.0-or-later
"""Add a preset's muscles to an armature, bind meshes to them, and save the result as a file."""

import argparse
from pathlib import Path

import bpy

from ..errors import SinewError
from ..muscles.placing.place import placement, preset_file
from ..muscles.placing.place.preset_to_rig import populate
from ..muscles.placing.recognise import creature, kind, segments
from ..scene.linked_data import writable
from ..skin import binding
from ..skin.main_skin import skins_to_fit
from .blend_file import add_file_argument, choose_scene, object_named, open_file, save_copy
from .output import Reporter


def add_arguments(parser: argparse.ArgumentParser):
    add_file_argument(parser)
    parser.add_argument("--armature", metavar="NAME", required=True, help="the armature")
    parser.add_argument(
        "--preset", metavar="NAME", required=True, help="a preset of Sinew (human, limbs, cat, myo) or a preset file"
    )
    parser.add_argument("--bind", metavar="MESH", action="append", default=[], help="a mesh to bind; can be repeated")
    parser.add_argument("--save", metavar="OUT", required=True, help="the .blend file to save")
    parser.add_argument("--no-fit", action="store_true", help="do not fit the muscles under the armature's meshes")
    parser.add_argument("--scene", metavar="NAME", help="the scene (default: the current scene of the file)")


def run(options: argparse.Namespace, reporter: Reporter) -> dict:
    """Adds, binds and saves. Returns the numbers of tissues and of bound vertices."""
    preset = preset_file.read(options.preset)
    open_file(options.file, reporter)
    choose_scene(options.scene)
    rig = writable(object_named(options.armature, "ARMATURE", "armature"))
    skins = [object_named(name, "MESH", "mesh") for name in options.bind]
    for skin in skins:
        if binding.check_bindable(skin) != rig:
            raise SinewError(f"{skin.name} follows another armature than {rig.name}")
    body = segments.recognise(rig, kind=preset.creature)
    shapes = populate(rig, preset, body, [] if options.no_fit else skins_to_fit(rig))
    for part, left_out in placement.left_out(preset, body).items():
        reporter.warn(f"{rig.name} has no {part}: {len(left_out)} tissues left out ({left_out[0]}, ...)")
    dropped = placement.not_placed(preset, body, shapes)
    if dropped:
        reporter.warn(f"{len(dropped)} muscles left out, because {placement.why_not_placed(preset)}: {', '.join(dropped)}")
    other = creature.warning(rig, body, options.preset, preset.creature, kind.kind_of_character(rig))
    if other:
        reporter.warn(other)
    reporter.say(f"{len(shapes)} tissues added to {rig.name} ({body.scheme})")
    bound = []
    for skin in skins:
        summary = binding.bind(skin, bpy.context.evaluated_depsgraph_get())
        for problem in summary.problems.values():
            reporter.warn(problem)
        reporter.say(f"{skin.name}: {summary.anchored} of {summary.vertices} vertices bound")
        bound.append({"mesh": skin.name, "vertices": summary.vertices, "anchored": summary.anchored})
    save_copy(options.save)
    return {
        "verb": "preset",
        "armature": rig.name,
        "scheme": body.scheme,
        "tissues": len(shapes),
        "bound": bound,
        "file": str(Path(options.save).absolute()),
    }
