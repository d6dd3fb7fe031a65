"""What a file holds for a Blender without Sinew: it is imported into an empty file, played, and told.

usage: (a Python with bpy, without Sinew) imported.py FILE FRAMES.json RESULT.npz

FRAMES.json is a list of frames. RESULT.npz gets `points` (frames, vertices, 3), world space, of the mesh with most vertices, and
`told`, a JSON text: what the file gave Blender, and all that it wrote to its log.
"""

import json
import sys
from pathlib import Path

import bpy
import numpy as np

IMPORTERS = {
    ".glb": lambda path: bpy.ops.import_scene.gltf(filepath=path),
    ".fbx": lambda path: bpy.ops.wm.fbx_import(filepath=path),
    ".usdc": lambda path: bpy.ops.wm.usd_import(filepath=path),
    ".abc": lambda path: bpy.ops.wm.alembic_import(filepath=path),
    ".blend": lambda path: bpy.ops.wm.open_mainfile(filepath=path),
}


def main(path: str, frames: list[int], result: str) -> None:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    IMPORTERS[Path(path).suffix](path)
    meshes = [found for found in bpy.context.view_layer.objects if found.type == "MESH" and found.visible_get()]
    skin = max(meshes, key=lambda found: len(found.data.vertices))
    points = []
    for frame in frames:
        bpy.context.scene.frame_set(frame)
        points.append(world_points(skin))
    np.savez(result, points=np.array(points), told=json.dumps(told(skin)))


def world_points(skin) -> np.ndarray:
    mesh = skin.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    points = np.empty(len(mesh.vertices) * 3, np.float32)
    mesh.vertices.foreach_get("co", points)
    world = np.array(skin.matrix_world)
    return points.reshape(-1, 3) @ world[:3, :3].T + world[:3, 3]


def told(skin) -> dict:
    keys = skin.data.shape_keys
    rigs = [modifier.object for modifier in skin.modifiers if modifier.type == "ARMATURE" and modifier.object]
    bones = rigs[0].data.bones if rigs else []
    return {
        "vertices": len(skin.data.vertices),
        "keys": len(keys.key_blocks) - 1 if keys else 0,
        "drivers": len(keys.animation_data.drivers) if keys and keys.animation_data else 0,
        "key curves": curves_of(keys),
        "bones": len(bones),
        "muscle bones": sum(bone.name.startswith(("muscle ", "muscle_")) for bone in bones),
        "bone curves": curves_of(rigs[0]) if rigs else 0,
        "most influences": max((len(vertex.groups) for vertex in skin.data.vertices), default=0),
        "modifiers": [modifier.type for modifier in skin.modifiers],
    }


def curves_of(owner) -> int:
    """How many curves play an owner: of one action several can."""
    animation = owner.animation_data if owner else None
    if animation is None or animation.action is None:
        return 0
    bags = (strip.channelbag(animation.action_slot) for layer in animation.action.layers for strip in layer.strips)
    return sum(len(bag.fcurves) for bag in bags if bag)


if __name__ == "__main__":
    main(sys.argv[1], json.loads(Path(sys.argv[2]).read_text()), sys.argv[3])
