# SPDX-License-Identifier: GPL-3.0-or-later
"""Migration of files of Sinew 0.1: settings, painted regions, and paths in keyframes and drivers move to their new names.

Only data is moved, nothing is run or evaluated. Values that are already set under a new name win, so a second migration
changes nothing. Linked data is moved in memory, in each session, since its file can't be written: the character works, and
a notice says which file to open and save.
"""

import re

import bpy

from ..scene import skin_regions, stored_settings
from . import old_names, updates
from .object_settings import VERSION

_SETTING_PATH = re.compile(r"^(pose\.bones\[.*\]\.)?sinew\.([a-z_]+)(.*)$", re.DOTALL)
_BAKED_KEY = re.compile(r"^(skin\.baked_keys\[.*\]\.)silenced$", re.DOTALL)
_NOTICE_OF_OLD_LIBRARY = (
    "{path} was saved by Sinew 0.1. Open and save it once with this version of Sinew: until then, its settings are moved "
    "to their new names each time that they are linked"
)
_NOTICE_OF_NEWER_FILE = "{name} was saved by a newer version of Sinew. Install that version to see all of its settings"

# the old names of settings that point to other tissues, and all others, with their new paths
_POINTERS = {name: old_names.OF_OBJECTS[name] for name in ("muscle", "wraps")}
_VALUES = {name: path for name, path in old_names.OF_OBJECTS.items() if name not in _POINTERS}

_notices: list[str] = []


def notices() -> list[str]:
    """What the user should know about the settings of this file, one text per notice."""
    return list(_notices)


def migrate(is_new_file: bool = True):
    """Migrates the whole file: after loading, and after data was appended or linked, which is not a new file."""
    if is_new_file:
        _notices.clear()
    old = migrate_objects()
    _migrate_painted()
    _migrate_paths()
    stamp()
    libraries = sorted({found.library.filepath for found in old if found.library})
    newer = [found.name for found in _with_settings() if found.sinew.version > VERSION]
    found = [_NOTICE_OF_OLD_LIBRARY.format(path=path) for path in libraries]
    found += [_NOTICE_OF_NEWER_FILE.format(name=name) for name in newer[:1]]
    _notices.extend(notice for notice in found if notice not in _notices)


def migrate_objects() -> list:
    """Migrates the settings of objects and bones; returns the objects that had settings of Sinew 0.1."""
    # an override is compared with the linked object, which must not be migrated yet
    objects = sorted(_with_settings(), key=lambda found: found.override_library is None)
    rigs = [found for found in bpy.data.objects if found.type == "ARMATURE" and found.pose]
    rigs.sort(key=lambda found: found.override_library is None)
    with updates.silent():
        pointing = [found for found in objects if _points_to_tissues(found)]
        migrated = [found for found in objects if _migrate_object(found, _VALUES)]
        # Blender accepts a pointer only to an object that is a tissue already
        for found in pointing:
            _migrate_object(found, _POINTERS)
        for found in objects:
            _point_to_overrides(found)
        migrated += [found for found in rigs if _migrate_bones(found) and found not in migrated]
    return migrated


def stamp():
    """Writes the version of the settings' layout to all local objects that have settings."""
    for found in _with_settings():
        if found.library is None and found.sinew.version < VERSION:
            found.sinew.version = VERSION


def new_path(path: str) -> str:
    """The path of a setting, relative to its object, in the current layout. Other paths are returned unchanged."""
    match = _SETTING_PATH.match(path)
    if match is None:
        return path
    bone, name, rest = match.groups(default="")
    names = old_names.OF_BONES if bone else old_names.OF_OBJECTS
    renamed = _BAKED_KEY.sub(r"\1muted_by_sinew", names.get(name, name) + rest)
    return f"{bone}sinew.{renamed}"


def _with_settings() -> list:
    return [found for found in bpy.data.objects if found.is_property_set("sinew")]


def _stored(carrier):
    """The ID properties of a carrier's settings, by their stored names; None where there are none."""
    root = stored_settings.properties_of(carrier)
    return root.get("sinew") if root is not None else None


def _points_to_tissues(found) -> bool:
    stored = _stored(found)
    return stored is not None and any(name in stored for name in _POINTERS)


def _migrate_object(found, names: dict[str, str]) -> bool:
    return _migrate_group(found.sinew, _stored(found), _stored_in_library(found), names)


def _migrate_bones(rig) -> bool:
    """Migrates the settings of a rig's bones; returns whether there were any of Sinew 0.1."""
    reference = _reference(rig)
    changed = []
    for bone in rig.pose.bones:
        if bone.is_property_set("sinew"):
            linked = reference.pose.bones.get(bone.name) if reference and reference.pose else None
            in_library = _stored(linked) if linked else None
            changed.append(_migrate_group(bone.sinew, _stored(bone), in_library, old_names.OF_BONES))
    return any(changed)


def _reference(found):
    """The linked object that an object overrides, or None."""
    return found.override_library.reference if found.override_library else None


def _stored_in_library(found):
    reference = _reference(found)
    return _stored(reference) if reference else None


def _migrate_group(settings, stored, in_library, names: dict[str, str]) -> bool:
    """Moves the values that are stored under old names; returns whether there were any.

    in_library: what the linked object stores, if the settings are of an override. A value that is set under its new name
    wins, except over a value that a shot of Sinew 0.1 overrides while the library was migrated.
    """
    present = [name for name in names if name in stored] if stored is not None else []
    overrides = _overrides_beside(settings.id_data) if present else {}
    for name in present:
        group, new = old_names.resolve(settings, names[name])
        is_overridden = in_library is not None and name not in in_library
        if is_overridden or not _is_set(group, new):
            _write(group, new, stored[name], overrides)
        del stored[name]
    for name in old_names.REMOVED:
        if stored is not None and name in stored:
            del stored[name]
    return bool(present)


def _is_set(group, name: str) -> bool:
    # a pointer that was only read counts as set, and is None
    return group.is_property_set(name) and getattr(group, name) is not None


def _write(group, name: str, value, overrides: dict):
    """Writes a stored value by the property's own type: a stored choice is a number, a collection a list of groups.

    overrides: the objects to point to instead of linked ones.
    """
    known = group.bl_rna.properties[name]
    if known.type == "COLLECTION":
        items = getattr(group, name)
        for stored in value:
            _write_all(items.add(), stored, overrides)
    elif known.type == "POINTER" and not isinstance(value, bpy.types.ID):
        _write_all(getattr(group, name), value, overrides)
    elif known.type == "ENUM":
        choice = next((item.identifier for item in known.enum_items if item.value == value), None)
        if choice is not None:
            setattr(group, name, choice)
    elif known.type == "BOOLEAN":
        setattr(group, name, bool(value))
    else:
        setattr(group, name, overrides.get(value, value) if known.type == "POINTER" else value)


def _write_all(group, stored, overrides: dict):
    for name, value in stored.items():
        name = old_names.OF_BAKED_KEYS.get(name, name)
        if value is not None and name in group.bl_rna.properties:
            _write(group, name, value, overrides)


def _overrides_beside(found) -> dict:
    """For an override: the other overrides of its character in this file, by the linked objects that they override."""
    if found.override_library is None:
        return {}
    root = found.override_library.hierarchy_root
    return {
        other.override_library.reference: other
        for other in bpy.data.objects
        if other.override_library and other.override_library.hierarchy_root == root
    }


def _point_to_overrides(found):
    """Repairs pointers of an override that Blender could not: a shot of Sinew 0.1 stores them under the old names."""
    settings = stored_settings.tissue_of(found)
    if settings is None or found.override_library is None:
        return
    pointers = [(settings, "muscle"), *((wrap, "sphere") for wrap in settings.wraps)]
    linked = [(group, name) for group, name in pointers if getattr(group, name) and getattr(group, name).library]
    overrides = _overrides_beside(found) if linked else {}
    for group, name in linked:
        target = overrides.get(getattr(group, name))
        if target:
            setattr(group, name, target)


def _migrate_painted():
    """Renames painted attributes and vertex groups; the old one stays where a new one exists."""
    for parameter in skin_regions.PARAMETERS:
        for former in parameter.painted_names[1:]:
            for mesh in bpy.data.meshes:
                if former in mesh.attributes and parameter.painted not in mesh.attributes:
                    mesh.attributes[former].name = parameter.painted
            for found in bpy.data.objects:
                if found.type == "MESH" and former in found.vertex_groups and parameter.painted not in found.vertex_groups:
                    found.vertex_groups[former].name = parameter.painted


def _migrate_paths():
    for action in bpy.data.actions:
        for layer in action.layers:
            for strip in layer.strips:
                for bag in strip.channelbags:
                    for curve in bag.fcurves:
                        _migrate_curve(curve)
    for owner in _animated():
        for curve in owner.animation_data.drivers:
            is_changed = _migrate_curve(curve)
            for variable in curve.driver.variables:
                for target in variable.targets:
                    path = new_path(target.data_path)
                    if path != target.data_path:
                        target.data_path, is_changed = path, True
            if is_changed:
                curve.driver.is_valid = True  # Blender marks a driver whose paths it did not find
    for scene in bpy.data.scenes:
        for keying_set in scene.keying_sets:
            for entry in keying_set.paths:
                path = new_path(entry.data_path)
                if path != entry.data_path:
                    entry.data_path = path


def _migrate_curve(curve) -> bool:
    path = new_path(curve.data_path)
    if path == curve.data_path:
        return False
    curve.data_path, curve.is_valid = path, True
    return True


def _animated():
    """All data of the file that has drivers or keys, with the node trees inside of it."""
    for known in bpy.data.bl_rna.properties:
        for found in getattr(bpy.data, known.identifier) if known.type == "COLLECTION" else ():
            for owner in (found, getattr(found, "node_tree", None)):
                if getattr(owner, "animation_data", None):
                    yield owner
