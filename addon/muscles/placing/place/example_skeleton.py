# SPDX-License-Identifier: GPL-3.0-or-later
"""The skeleton of the example character: a standing human of 1.75 m, with arms at 45 degrees and bone names of Rigify."""

import bpy

# bone: (parent, head, tail), in centimetres; the right side mirrors the left. x: to the left, y: to the back, z: up
_CENTRAL = {
    "spine": ("", (0, 3, 92), (0, 1, 104)),
    "spine.001": ("spine", (0, 1, 104), (0, 0, 115)),
    "spine.002": ("spine.001", (0, 0, 115), (0, 1, 130)),
    "spine.003": ("spine.002", (0, 1, 130), (0, 2, 147)),
    "spine.004": ("spine.003", (0, 2, 147), (0, 0, 153)),
    "spine.005": ("spine.004", (0, 0, 153), (0, -1, 158)),
    "spine.006": ("spine.005", (0, -1, 158), (0, -1, 175)),
}
_LEFT = {
    "shoulder": ("spine.003", (2, -5, 142), (15, 2, 142)),
    "upper_arm": ("shoulder", (17, 2, 140), (38, 3, 121)),
    "forearm": ("upper_arm", (38, 3, 121), (57, 0, 103)),
    "hand": ("forearm", (57, 0, 103), (65, -1, 95)),
    "pelvis": ("spine", (0, 3, 92), (10, -3, 104)),
    "thigh": ("spine", (9, 1, 95), (9, -2, 49)),
    "shin": ("thigh", (9, -2, 49), (9, 2, 9)),
    "foot": ("shin", (9, 2, 9), (9, -9, 2)),
    "toe": ("foot", (9, -9, 2), (9, -15, 2)),
}
_CENTRAL_NAMES = frozenset(_CENTRAL)


def create(context):
    """Creates the armature at the origin and makes it the only selected object, and the active one. Returns it."""
    armature = bpy.data.armatures.new("Example")
    rig = bpy.data.objects.new("Example", armature)
    context.scene.collection.objects.link(rig)
    for selected in context.view_layer.objects.selected:
        selected.select_set(False)
    rig.select_set(True)
    context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    for name, (parent, head, tail) in _CENTRAL.items():
        _add(armature, name, parent, head, tail, 1.0)
    for side, sign in ((".L", 1.0), (".R", -1.0)):
        for name, (parent, head, tail) in _LEFT.items():
            _add(armature, name + side, parent if parent in _CENTRAL_NAMES else parent + side, head, tail, sign)
    bpy.ops.object.mode_set(mode="OBJECT")
    return rig


def _add(armature, name: str, parent: str, head: tuple, tail: tuple, sign: float):
    bone = armature.edit_bones.new(name)
    bone.head, bone.tail = ((0.01 * sign * x, 0.01 * y, 0.01 * z) for x, y, z in (head, tail))
    if parent:
        bone.parent = armature.edit_bones[parent]
        bone.use_connect = (bone.parent.tail - bone.head).length < 1e-4
