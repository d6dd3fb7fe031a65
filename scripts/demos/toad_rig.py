"""The armature of a sitting toad, with the bone names of Rigify's cat, so that the cat's muscles fit it.

Positions are millimetres on a toad 90 mm long, with the proportions of the common toad (Bufo bufo): a broad head, a third of
the body long, no neck to speak of, no tail, hind legs folded at the sides.
"""

import bpy
from mathutils import Vector

MM = 0.001
# bone: (head, tail, parent). Bones of the left side end with .L and are mirrored.
BONES = {
    "spine": ((0, 40, 20), (0, 26, 27), ""),
    "spine.001": ((0, 26, 27), (0, 13, 31), "spine"),
    "spine.002": ((0, 13, 31), (0, 0, 34), "spine.001"),
    "spine.003": ((0, 0, 34), (0, -20, 38), "spine.002"),
    "spine.004": ((0, -20, 38), (0, -26, 39), "spine.003"),
    "spine.006": ((0, -26, 39), (0, -54, 35), "spine.004"),
    "jaw": ((0, -26, 28), (0, -53, 30), "spine.006"),
    "eye.L": ((9, -36, 36), (17, -42, 48), "spine.006"),
    "shoulder.L": ((7, -6, 40), (19, -13, 25), "spine.003"),
    "upper_arm.L": ((19, -13, 25), (36, -4, 16), "shoulder.L"),
    "forearm.L": ((36, -4, 16), (33, -24, 6), "upper_arm.L"),
    "hand.L": ((33, -24, 6), (30, -31, 3), "forearm.L"),
    "f_toe.L": ((30, -31, 3), (26, -40, 1), "hand.L"),
    "thigh.L": ((8, 38, 18), (40, 16, 16), "spine"),
    "shin.L": ((40, 16, 16), (17, 44, 8), "thigh.L"),
    "foot.L": ((17, 44, 8), (36, 36, 4), "shin.L"),
    "r_toe.L": ((36, 36, 4), (46, 24, 1.5), "foot.L"),
}
# The first and last point of each digit; two bones each.
FORE_DIGITS = {
    "f_index": ((28, -31, 3), (20, -38, 1.2)),
    "f_middle": ((29, -32, 3), (24, -44, 1.2)),
    "f_ring": ((31, -32, 3), (31, -46, 1.2)),
    "f_pinky": ((33, -31, 3), (38, -42, 1.2)),
}
HIND_DIGITS = {
    "r_index": ((36, 35, 3.5), (34, 22, 1.2)),
    "r_middle": ((38, 34, 3.5), (42, 15, 1.2)),
    "r_ring": ((40, 34, 3.5), (52, 10, 1.2)),
    "r_pinky": ((41, 36, 3.5), (56, 22, 1.2)),
}


def make():
    """The armature, active in the scene."""
    data = bpy.data.armatures.new("Toad")
    rig = bpy.data.objects.new("Toad", data)
    bpy.context.scene.collection.objects.link(rig)
    bpy.context.view_layer.objects.active = rig
    rig.select_set(True)
    bpy.ops.object.mode_set(mode="EDIT")
    bones = dict(BONES)
    for digits, parent in ((FORE_DIGITS, "f_toe.L"), (HIND_DIGITS, "r_toe.L")):
        for name, (start, end) in digits.items():
            middle = tuple(0.45 * a + 0.55 * b for a, b in zip(start, end))
            bones[f"{name}.001.L"] = (start, middle, parent)
            bones[f"{name}.002.L"] = (middle, end, f"{name}.001.L")
    for name, (head, tail, parent) in bones.items():
        for side in ("L", "R") if name.endswith(".L") else ("",):
            mirror = Vector((-MM if side == "R" else MM, MM, MM))
            made = data.edit_bones.new(name.removesuffix("L") + side if side else name)
            made.head, made.tail = Vector(head) * mirror, Vector(tail) * mirror
            if parent:
                made.parent = data.edit_bones[parent.removesuffix("L") + side if parent.endswith(".L") else parent]
    bpy.ops.object.mode_set(mode="OBJECT")
    return rig
