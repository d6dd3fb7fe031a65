# SPDX-License-Identifier: GPL-3.0-or-later
"""From a rig and a preset to muscles in place: which bones are which, where a muscle goes, how thick it may be.

    segments.recognise(rig) -> Body          preset_file.read(name) -> Preset
    SkinSurface.of(mesh_object, rig)         placement.place(preset, body, skin) -> [TissueShape]
    automatic.muscles(rig, joint, ...)       fit.fit_all(shapes, skin) -> [TissueShape]

Everything is rest pose and armature space; nothing here reads the current pose or writes Blender data.
"""
