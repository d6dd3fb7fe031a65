# SPDX-License-Identifier: GPL-3.0-or-later
"""Placing muscles on a rig: which bone is which part of the body, where a muscle goes, and how thick it can be.

    segments.recognise(rig) -> Body          preset_file.read(name) -> Preset
    SkinSurface.of(mesh_object, rig)         placement.place(preset, body, skin) -> [TissueShape]
    automatic.muscles(rig, joint, ...)       fit.fit_all(shapes, skin) -> [TissueShape]

Everything is in the rest pose and in armature space. Nothing here reads the current pose or writes Blender data, except
`place/population`, which adds a whole preset to a rig. The mathematics is in docs/mathematics/fitting.md.
"""
