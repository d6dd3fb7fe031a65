# SPDX-License-Identifier: GPL-3.0-or-later
"""Skeletons of creatures, built in code, with names of many conventions: (name, head, tail, parent) for each bone,
facing -Y.
"""

import bpy
from conftest import select
from mathutils import Matrix, Vector

# Joints of the left side and the middle: name of a part, position. A limb's parts run from the body outward.
DOG_FORE = ((0.03, -0.1, 0.6), (0.08, -0.3, 0.42), (0.08, -0.22, 0.25), (0.08, -0.25, 0.06), (0.08, -0.3, 0.01))
DOG_HIND = ((0.07, 0.3, 0.52), (0.09, 0.24, 0.32), (0.09, 0.4, 0.17), (0.09, 0.36, 0.04), (0.09, 0.3, 0.01))
HORSE_FORE = ((0.08, -0.25, 1.45), (0.17, -0.6, 1.05), (0.17, -0.5, 0.8), (0.17, -0.5, 0.4), (0.17, -0.55, 0.02))
HORSE_HIND = ((0.14, 0.6, 1.2), (0.18, 0.45, 0.95), (0.18, 0.72, 0.6), (0.18, 0.7, 0.2), (0.18, 0.62, 0.02))
DOG_SPINE = ((0, 0.32, 0.56), (0, 0.1, 0.58), (0, -0.12, 0.58), (0, -0.34, 0.58), (0, -0.5, 0.75), (0, -0.72, 0.72))
HORSE_SPINE = ((0, 0.65, 1.35), (0, 0.2, 1.38), (0, -0.25, 1.35), (0, -0.6, 1.3), (0, -1.0, 1.75), (0, -1.4, 1.45))
BIRD_SPINE = ((0, 0.05, 0.24), (0, -0.04, 0.27), (0, -0.12, 0.31), (0, -0.17, 0.35), (0, -0.22, 0.42), (0, -0.3, 0.41))
BIRD_LEG = ((0.04, 0.03, 0.22), (0.06, -0.03, 0.16), (0.06, 0.05, 0.09), (0.06, 0.0, 0.02), (0.06, -0.05, 0.0))
WING = ((0.05, -0.1, 0.32), (0.2, -0.06, 0.34), (0.4, -0.12, 0.34), (0.6, -0.05, 0.34))
TAIL = ((0, 0.4, 0.55), (0, 0.6, 0.5), (0, 0.8, 0.45), (0, 1.0, 0.4))


def chain(names, points, parent=""):
    """Bones through these points, one after the other."""
    bones = []
    for name, head, tail in zip(names, points, points[1:], strict=False):
        bones.append((name, head, tail, parent))
        parent = name
    return bones


def pair(names, points, parent):
    """A chain on the left and its mirror image. names: with {} for the side, and a pair of marks before them."""
    marks, names = names
    bones = []
    for mark, sign in zip(marks, (1, -1), strict=True):
        mirrored = [(sign * x, y, z) for x, y, z in points]
        bones += chain([name.format(mark) for name in names], mirrored, parent)
    return bones


def on_fours(spine, fore, hind, tail=(), size="dog"):
    """A quadruped. spine: five names from the pelvis to the head. fore, hind: ((left, right), names)."""
    along, front, rear = (DOG_SPINE, DOG_FORE, DOG_HIND) if size == "dog" else (HORSE_SPINE, HORSE_FORE, HORSE_HIND)
    bones = chain(spine, along)
    skip = len(front) - 1 - len(fore[1])
    bones += pair(fore, front[skip:] if skip > 0 else front, spine[2])
    bones += pair(hind, rear, spine[0])
    return bones + chain(tail, TAIL, spine[0])


def bird(spine, wing, leg):
    """A standing bird with spread wings."""
    return chain(spine, BIRD_SPINE) + pair(wing, WING, spine[2]) + pair(leg, BIRD_LEG, spine[0])


def fish(spine, fin, extra=(), headfirst=True):
    """A fish of a row of bones. extra: names of fins in the middle."""
    points = [(0, 0.15 * i, 0) for i in range(len(spine) + 1)]
    bones = chain(spine, points if headfirst else points[::-1])
    along = spine[1] if headfirst else spine[-2]
    bones += pair(fin, ((0.05, 0.2, -0.03), (0.2, 0.3, -0.08), (0.3, 0.4, -0.1)), along)
    return bones + [(name, (0, 0.4, 0.1), (0, 0.5, 0.25), spine[len(spine) // 2]) for name in extra]


def many_legs(body, leg, pairs):
    """An arthropod. leg: ((left, right), names) with {{}} for the number of the pair."""
    marks, names = leg
    bones = chain(body, ((0, 0.3, 0.3), (0, 0, 0.3), (0, -0.2, 0.3), (0, -0.4, 0.3)))
    for number in range(pairs):
        y = 0.1 - 0.12 * number
        points = ((0.08, y, 0.3), (0.4, 2 * y, 0.5), (0.8, 3 * y, 0.3), (1.0, 3.5 * y, 0.0))
        bones += pair((marks, [name.replace("#", "ABCDEF"[number]) for name in names]), points, body[1])
    return bones


def row(names, step=(0, 0.2, 0)):
    """A row of bones without limbs."""
    return chain(names, [tuple(i * s for s in step) for i in range(len(names) + 1)])


def built(bones, turn=None, name="Rig"):
    """A rig of these bones, turned as a whole in armature space by a matrix that the object's transform undoes."""
    turn = turn or Matrix()
    data = bpy.data.armatures.new(name)
    rig = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(rig)
    select(rig)
    bpy.ops.object.mode_set(mode="EDIT")
    for bone, head, tail, parent in bones:
        made = data.edit_bones.new(bone)
        made.head, made.tail = turn @ Vector(head), turn @ Vector(tail)
        made.parent = data.edit_bones[parent] if parent else None
    bpy.ops.object.mode_set(mode="OBJECT")
    select(rig)
    return rig
