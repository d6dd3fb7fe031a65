"""Builds the moving body of the demo, bound and baked, for the export scripts.

skin, rig = export_scene.build(keys="CORRECTIVES")
"""

import time

import bpy
from build.console import say
from data import body_in_blender
from demos import motion

# the demo's joint angles and a little more, for the left side; mirrored for the right side
_LEFT = {
    "upperarm01": "X -20..20 Y -60..20 Z -20..60",
    "upperarm02": "Y -50..20",
    "lowerarm01": "0..120",
    "upperleg01": "X -70..20 Z -20..20",
    "lowerleg01": "0..110",
}
_RIGHT = _LEFT | {"upperarm01": "X -20..20 Y -20..60 Z -60..20", "upperarm02": "Y -20..50"}
ANGLES = {f"{bone}.{side}": angles for side, joints in (("L", _LEFT), ("R", _RIGHT)) for bone, angles in joints.items()}
TOLERANCE_MM = 1.0
KEYS = ("CORRECTIVES", "FRAMES", "NONE")


def build(keys: str, influences: str = "4") -> tuple[bpy.types.Object, bpy.types.Object]:
    """The live mesh and its armature, with baked keys of a kind, and an export copy with muscle bones.

    influences: the most bones per vertex of the copy.
    """
    bpy.ops.wm.read_factory_settings(use_empty=True)
    skin, rig = body_in_blender.build()
    motion.animate(rig)
    make_active(rig)
    bpy.ops.sinew.add_preset(name="limbs")
    make_active(skin)
    bpy.ops.sinew.bind()
    bake(skin, rig, keys, influences)
    return skin, rig


def bake(skin, rig, keys: str, influences: str) -> None:
    make_active(skin)
    start = time.perf_counter()
    if keys == "CORRECTIVES":
        bpy.ops.sinew.bake_correctives(joints=",".join(ANGLES), angles=",".join(ANGLES.values()), tolerance=TOLERANCE_MM)
    elif keys == "FRAMES":
        bpy.ops.sinew.bake_shape_keys(frame_start=motion.FRAME_START, frame_end=motion.FRAME_END)
    say(f"{keys.lower()}: {time.perf_counter() - start:.1f} s")
    start = time.perf_counter()
    make_active(rig)
    bpy.ops.sinew.bake_bones(frame_start=motion.FRAME_START, frame_end=motion.FRAME_END, influences=influences)
    say(f"muscle bones: {time.perf_counter() - start:.1f} s")
    skin.sinew.skin.live = True


def make_active(target) -> None:
    for other in bpy.context.selected_objects:
        other.select_set(False)
    target.select_set(True)
    bpy.context.view_layer.objects.active = target


def copy_of(rig):
    """Shows a rig's export copy; returns its mesh."""
    collection = rig.sinew.rig.export_copy
    bpy.context.view_layer.layer_collection.children[collection.name].exclude = False
    bpy.context.view_layer.update()
    return next(found for found in collection.objects if found.type == "MESH")


def hide_copy(rig) -> None:
    bpy.context.view_layer.layer_collection.children[rig.sinew.rig.export_copy.name].exclude = True
