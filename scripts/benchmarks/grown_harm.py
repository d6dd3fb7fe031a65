"""Sweeps the joints of a grown skin and compares each pose with the Armature modifier alone, as scripts/harm.py does.

usage: python3 scripts/run_in_blender.py scripts/benchmarks/grown_harm.py [ANIMAL...] [--rigid] [--resolution 108]
       [--degrees 45,90] [--joints 16] [--worse]

ANIMAL: cat, wolf, horse or human, a metarig of Rigify. --rigid switches Elastic off. Stretch is that of the 99th
percentile of the edges that stretch by more than 2 %; the last column is that of the worst edge of all poses.
"""

import argparse

import bpy
import addon_utils

from benchmarks.harm_in_blender import HEADER, Skin, make_active, sweep_joints

PRESETS = {"cat": "cat", "wolf": "quadruped", "horse": "quadruped", "human": "human"}
THICKNESS_OF_HEIGHT = 0.01  # of the skin over all tissues


def grown(animal: str, resolution: int, elastic: bool):
    """A new file with a metarig, its preset and a skin grown over them. Returns the rig, its mesh, and what is compared."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    addon_utils.enable("rigify", default_set=True)
    getattr(bpy.ops.object, f"armature_{animal}_metarig_add")()
    rig = bpy.context.object
    bpy.ops.sinew.add_preset(name=PRESETS[animal])
    bpy.ops.sinew.grow_skin(resolution=resolution, thickness=THICKNESS_OF_HEIGHT * rig.dimensions.z, smoothing=8)
    mesh = next(found for found in bpy.data.objects if found.type == "MESH" and found.sinew.skin.growth.is_grown)
    make_active(mesh)
    bpy.ops.sinew.unbind()
    skin = Skin(mesh)
    make_active(mesh)
    mesh.sinew.skin.elastic = elastic
    bpy.ops.sinew.bind()
    return rig, mesh, skin


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("animals", nargs="*", choices=[[], *PRESETS], default=["cat"], metavar="ANIMAL")
    parser.add_argument("--rigid", action="store_true", help="switch Elastic off")
    parser.add_argument("--resolution", type=int, default=108)
    parser.add_argument("--degrees", default="45,90", metavar="ANGLE,...")
    parser.add_argument("--joints", type=int, default=16)
    parser.add_argument("--worse", action="store_true", help="list the poses that are worse")
    wanted = parser.parse_args()
    print(HEADER, flush=True)
    for animal in wanted.animals:
        rig, mesh, skin = grown(animal, wanted.resolution, not wanted.rigid)
        options = {
            "degrees": [float(angle) for angle in wanted.degrees.split(",")],
            "joints": wanted.joints,
            "worse": wanted.worse,
        }
        sweep_joints(f"{animal}, {'rigid' if wanted.rigid else 'elastic'}", rig, [mesh], [skin], options)


if __name__ == "__main__":
    main()
