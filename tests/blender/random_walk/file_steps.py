# SPDX-License-Identifier: GPL-3.0-or-later
"""Steps of the random walk that change the scene: undo, files, modes, names, deletions, links, Sinew off and on."""

import bpy
import addon_utils
from checker import compare, shown
from world import Nothing, World

EXTENSION = "bl_ext.user_default.sinew"
MODES = {
    "MESH": ("OBJECT", "EDIT", "SCULPT", "WEIGHT_PAINT", "VERTEX_PAINT"),
    "ARMATURE": ("OBJECT", "EDIT", "POSE"),
    "EMPTY": ("OBJECT",),
}


def push(_world: World):
    bpy.ops.ed.undo_push(message="step")


def undo(_world: World):
    if bpy.ops.ed.undo.poll():
        bpy.ops.ed.undo()


def redo(_world: World):
    if bpy.ops.ed.redo.poll():
        bpy.ops.ed.redo()


def reopen(world: World):
    """Saves and opens the file. What it shows must stay, except for overrides: Blender does not save all edits of these."""
    world.to_object_mode()
    scene = bpy.context.scene
    scene.frame_set(scene.frame_current, subframe=scene.frame_subframe)  # opening a file drops edits that are not keyed
    for rig in world.objects("ARMATURE"):
        rig.update_tag()  # Blender does not evaluate all edits of bones by scripts, also for meshes without Sinew
    before = [_of_local(found) for found in shown()]
    path = str(world.folder / f"walk{world.saved % 3}.blend")
    world.saved += 1
    bpy.ops.wm.save_as_mainfile(filepath=path)
    wrong = compare(*before, *map(_of_local, shown()))
    assert not wrong, f"after saving: {'; '.join(wrong)}"
    bpy.ops.wm.open_mainfile(filepath=path)
    wrong = compare(*before, *map(_of_local, shown()))
    assert not wrong, f"after opening: {'; '.join(wrong)}"
    bpy.ops.ed.undo_push(message="opened")


def _of_local(by_name: dict) -> dict:
    """The entries of the meshes that depend on no linked or overridden object."""
    found = {each.name_full: each for each in bpy.data.objects}
    return {name: value for name, value in by_name.items() if not _depends_on_library(found[name])}


def _depends_on_library(mesh) -> bool:
    objects = [mesh, mesh.parent, mesh.data, *(getattr(modifier, "object", None) for modifier in mesh.modifiers)]
    return any(found and (found.library or found.override_library) for found in objects)


def change_mode(world: World):
    active = world.pick(world.objects("MESH") + world.objects("ARMATURE"))
    world.activate(active)
    bpy.ops.object.mode_set(mode=world.pick(MODES[active.type]))


def rename(world: World):
    renamed = world.pick(sorted(bpy.data.objects, key=lambda found: found.name_full))
    if renamed.library is None:
        renamed.name = world.pick(("Arm", "Biceps", "Biceps.001", "Æ", "x" * 60, renamed.name + "a"))
        if renamed.data and renamed.data.library is None:
            renamed.data.name = renamed.name


def delete(world: World):
    """Deletes an object, but not the last skin: the walk would have nothing left to do."""
    found = world.pick(world.objects("MESH") + world.objects("ARMATURE") + 4 * world.objects("EMPTY"))
    if found.type != "EMPTY" and len(world.objects(found.type)) < 3:
        raise Nothing
    if world.chance():
        world.activate(found)
        bpy.ops.object.delete()
    else:
        world.to_object_mode()
        bpy.data.objects.remove(found)


def duplicate(world: World):
    if len(bpy.data.objects) > 24:
        raise Nothing
    found = world.pick(world.objects("MESH") + world.objects("ARMATURE") + 4 * world.objects("EMPTY"))
    world.activate(found)
    bpy.ops.object.duplicate(linked=world.chance())


def duplicate_character(world: World):
    if len(bpy.data.objects) > 16:
        raise Nothing
    rig = world.rig()
    world.activate(rig, *(child for child in rig.children if child.visible_get()))
    bpy.ops.object.duplicate(linked=world.chance())


def join(world: World):
    skin, other = world.mesh(), world.mesh()
    if skin == other or len(world.objects("MESH")) < 3 or len(skin.data.vertices) + len(other.data.vertices) > 800:
        raise Nothing
    world.activate(skin, other)
    bpy.ops.object.join()


def change_parent(world: World):
    mesh = world.mesh()
    rig = world.pick([*world.objects("ARMATURE"), None])
    if world.chance():
        mesh.parent = rig
    modifiers = [modifier for modifier in mesh.modifiers if modifier.type == "ARMATURE"]
    if modifiers:
        world.pick(modifiers).object = rig


def change_modifiers(world: World):
    mesh = world.mesh()
    what = world.pick(("eye", "eye", "render", "setting", "add", "remove", "attribute"))
    if what == "add" and len(mesh.modifiers) < 4:
        kind = world.pick(("SMOOTH", "TRIANGULATE", "ARMATURE"))
        modifier = mesh.modifiers.new(kind.title(), kind)
        if kind == "ARMATURE":
            modifier.object = world.rig()
    elif what == "attribute":
        attribute = mesh.data.attributes.get("sinew_correction")
        if attribute:
            mesh.data.attributes.remove(attribute)
    elif mesh.modifiers:
        modifier = world.pick(mesh.modifiers)
        if what == "eye":
            modifier.show_viewport = not modifier.show_viewport
        elif what == "render":
            modifier.show_render = not modifier.show_render
        elif what == "setting" and modifier.type == "ARMATURE":
            name = world.pick(("use_deform_preserve_volume", "use_vertex_groups", "use_bone_envelopes"))
            setattr(modifier, name, not getattr(modifier, name))
        elif what == "remove" and world.chance(0.3):
            mesh.modifiers.remove(modifier)


def change_collections(world: World):
    """An object goes to another collection, or a collection is excluded or included."""
    layer = bpy.context.view_layer.layer_collection
    collection = bpy.data.collections.get("Other")
    if collection is None:
        collection = bpy.data.collections.new("Other")
    if collection.name not in layer.children:
        bpy.context.scene.collection.children.link(collection)
    if world.chance(0.4):
        layer.children[collection.name].exclude = not layer.children[collection.name].exclude
    elif world.chance(0.3):
        collection.hide_viewport = not collection.hide_viewport
    else:
        found = world.tissue()
        for holder in found.users_collection:
            holder.objects.unlink(found)
        world.pick((collection, bpy.context.scene.collection)).objects.link(found)


def change_scene(world: World):
    """Another scene, or another view layer, shows the same objects."""
    if world.chance() and len(bpy.data.scenes) < 3:
        bpy.data.scenes.remove(bpy.context.scene.copy()) if world.chance() else bpy.context.scene.copy()
    else:
        bpy.context.window.scene = world.pick(sorted(bpy.data.scenes, key=lambda scene: scene.name))


def link_character(world: World):
    """Links a character from a library, overrides it, or reloads and resyncs the library."""
    world.to_object_mode()
    path = world.folder / "library.blend"
    if not path.exists():
        _save_library(world, path)
    libraries = [library for library in bpy.data.libraries if library.filepath.endswith("library.blend")]
    if libraries and (len(bpy.data.objects) > 24 or world.chance()):
        bpy.ops.wm.save_as_mainfile(filepath=str(world.folder / "shot.blend"))
        libraries[0].reload()
        overridden = [found for found in bpy.data.objects if found.override_library]
        if overridden:
            hierarchy = world.pick(sorted(overridden, key=lambda found: found.name))
            hierarchy.override_library.resync(bpy.context.scene, view_layer=bpy.context.view_layer)
    elif len(bpy.data.objects) <= 24:
        with bpy.data.libraries.load(str(path), link=True) as (_source, target):
            target.collections = ["Character"]
        if target.collections[0]:
            target.collections[0].override_hierarchy_create(
                bpy.context.scene, bpy.context.view_layer, do_fully_editable=True
            )


def _save_library(world: World, path):
    """Writes one character, with what it needs, in a collection."""
    rig = world.rig()
    collection = bpy.data.collections.new("Character")
    for found in (rig, *rig.children):
        collection.objects.link(found)
    bpy.data.libraries.write(str(path), {collection})
    bpy.data.collections.remove(collection)


def append_character(world: World):
    path = world.folder / "library.blend"
    if not path.exists() or len(bpy.data.objects) > 28:
        raise Nothing
    world.to_object_mode()
    with bpy.data.libraries.load(str(path)) as (_source, target):
        target.collections = ["Character"]
    if target.collections[0]:
        bpy.context.scene.collection.children.link(target.collections[0])


def purge(_world: World):
    bpy.data.orphans_purge(do_recursive=True)


def disable_and_enable(world: World):
    """Sinew off: the meshes follow their own modifiers. On again: as before."""
    world.to_object_mode()
    before = shown()
    addon_utils.disable(EXTENSION)
    bpy.context.view_layer.update()
    addon_utils.enable(EXTENSION)
    from bl_ext.user_default.sinew.live import handlers

    handlers._after_load()  # a timer of Blender calls it, which does not run in the background
    wrong = compare(*before, *shown())
    assert not wrong, f"after disabling and enabling: {'; '.join(wrong)}"


WITHOUT_PUSH = (push, undo, redo, reopen)
STEPS = (
    (push, 2), (undo, 9), (redo, 5), (reopen, 3), (change_mode, 4), (rename, 3), (delete, 3), (duplicate, 2),
    (duplicate_character, 1), (join, 1), (change_parent, 2), (change_modifiers, 3), (change_collections, 2),
    (change_scene, 1), (link_character, 2), (append_character, 1), (purge, 1), (disable_and_enable, 1),
)  # fmt: skip
