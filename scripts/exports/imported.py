"""Reads what files hold for a Blender without Sinew: imports each into an empty file and plays it.

usage: (a Python with bpy, without Sinew) imported.py REQUESTS.json

REQUESTS.json is a list of {"file", "frames", "mesh", "result"}. mesh: a name, or null for the mesh with the most vertices.
result: the path of an .npz file with `points`, (frames, vertices, 3) in world space, and `contents`, a JSON text that says
what Blender read from the file, and what it does not understand.
"""

import json
import os
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


def main(requests: list[dict]) -> None:
    for request in requests:
        bpy.ops.wm.read_factory_settings(use_empty=True)
        IMPORTERS[Path(request["file"]).suffix](request["file"])
        skin = mesh_named(request["mesh"]) if request["mesh"] else largest_mesh()
        points = []
        for frame in request["frames"]:
            bpy.context.scene.frame_set(frame)
            points.append(world_points(skin))
        np.savez(request["result"], points=np.array(points), contents=json.dumps(contents_of(skin)))


def mesh_named(name: str):
    """The mesh object of a name. USD can give the name to an Empty above the mesh."""
    meshes = [found for found in bpy.data.objects if found.type == "MESH"]
    return next(found for found in meshes if name in (found.name, found.data.name, found.parent and found.parent.name))


def largest_mesh():
    meshes = [found for found in bpy.context.view_layer.objects if found.type == "MESH" and found.visible_get()]
    return max(meshes, key=lambda found: len(found.data.vertices))


def world_points(skin) -> np.ndarray:
    mesh = skin.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    points = np.empty(len(mesh.vertices) * 3, np.float32)
    mesh.vertices.foreach_get("co", points)
    world = np.array(skin.matrix_world)
    return points.reshape(-1, 3) @ world[:3, :3].T + world[:3, 3]


def contents_of(skin) -> dict:
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
        "unknown": [*unknown_nodes(), *bad_drivers()],
    }


def unknown_nodes() -> list[str]:
    """Nodes whose type this Blender does not know."""
    return [
        f"{group.name}: {node.name}"
        for group in bpy.data.node_groups
        for node in group.nodes
        if node.bl_idname == "NodeUndefined"
    ]


def bad_drivers() -> list[str]:
    """Drivers that cannot be evaluated."""
    owners = [*bpy.data.objects, *bpy.data.shape_keys, *bpy.data.meshes, *bpy.data.armatures]
    curves = [curve for owner in owners if owner.animation_data for curve in owner.animation_data.drivers]
    return [curve.data_path for curve in curves if not curve.is_valid or not curve.driver.is_valid]


def curves_of(owner) -> int:
    """The number of F-curves of an owner's action slot."""
    animation = owner.animation_data if owner else None
    if animation is None or animation.action is None:
        return 0
    bags = (strip.channelbag(animation.action_slot) for layer in animation.action.layers for strip in layer.strips)
    return sum(len(bag.fcurves) for bag in bags if bag)


if __name__ == "__main__":
    main(json.loads(Path(sys.argv[1]).read_text()))
    # without tearing down bpy, which can hang (4.5) and prints messages about leaked memory
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(0)
