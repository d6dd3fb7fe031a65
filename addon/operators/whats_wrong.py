# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.whats_wrong` copies what a report of a problem needs: versions, characters, settings, problems and the log."""

import os
import platform
import sys
from pathlib import Path

import bpy
import _sinew
import numpy as np
from bpy.types import Operator

from ..display import views
from ..files import log
from ..live import session
from ..scene import characters
from .base import Translated

TEXT = "Sinew Report"
MANIFEST = Path(__file__).parents[1] / "blender_manifest.toml"


class SINEW_OT_whats_wrong(Translated, Operator):
    """Copy versions, characters, changed settings, problems and the log as text, to report a problem"""

    bl_idname, bl_label, bl_options = "sinew.whats_wrong", "What's Wrong", {"REGISTER", "UNDO"}

    def execute(self, context):
        text = report(context)
        context.window_manager.clipboard = text
        stored = bpy.data.texts.get(TEXT) or bpy.data.texts.new(TEXT)
        stored.from_string(text)
        self.report({"INFO"}, f"Copied. It is also the text '{TEXT}' in the Text Editor. Add what you did and what you saw")
        return {"FINISHED"}


def report(context) -> str:
    """The report as text. It holds names of objects and bones, but no folders and no geometry."""
    lines = ["Sinew report", "", *_versions(), "", *_file(context)]
    for character in characters.in_file():
        lines += ["", *_character(character)]
    lines += ["", "Log:", *(log.last_lines() or ["(empty)"])]
    return "\n".join(lines) + "\n"


def _versions() -> list[str]:
    return [
        f"Sinew {version()}, core {_sinew.__version__}, {os.cpu_count()} cores",
        f"Blender {bpy.app.version_string} {bpy.app.build_hash.decode(errors='replace')}",
        f"Python {sys.version.split()[0]}, numpy {np.__version__}",
        platform.platform(),
    ]


def version() -> str:
    """The version in the extension's manifest."""
    for line in MANIFEST.read_text(encoding="utf-8").splitlines():
        if line.startswith("version = "):
            return line.partition("=")[2].strip().strip('"')
    return "?"


def _file(context) -> list[str]:
    scene = context.scene
    units = scene.unit_settings
    active = context.view_layer.objects.active
    return [
        f"File: {len(bpy.data.objects)} objects, saved in {'.'.join(map(str, bpy.data.version))}, "
        f"units {units.system} x {units.scale_length:g}",
        f"Scene: frames {scene.frame_start}..{scene.frame_end}, now {scene.frame_current}, mode {context.mode}, "
        f"active {active.name if active else 'nothing'}",
    ]


def _character(character) -> list[str]:
    rig = character.rig.find()
    if rig is None:
        return [f"Armature {character.rig.name}: renamed"]
    kinds: dict[str, int] = {}
    for key in character.tissues:
        tissue = key.find()
        if tissue:
            kinds[tissue.sinew.tissue.kind] = kinds.get(tissue.sinew.tissue.kind, 0) + 1
    scale = " ".join(f"{value:g}" for value in rig.matrix_world.to_scale())
    tissues = ", ".join(f"{count} {kind.lower()}" for kind, count in sorted(kinds.items()))
    lines = [
        f"Armature {rig.name}: {len(rig.data.bones)} bones, {rig.data.pose_position.lower()} position, mode {rig.mode}, "
        f"scale {scale}, linked {bool(rig.library)}, override {bool(rig.override_library)}",
        f"  tissues: {tissues}; {len(character.vias)} via points; view {views.of(rig)}",
        f"  settings: {_changed(rig.sinew.rig)}",
    ]
    state = session.cached_rig(rig)
    if state is None:
        lines.append("  not computed yet")
    else:
        lines.append(f"  acting: {len(state.solved)} of {len(character.tissues)}")
        lines += [f"  problem: {text}" for text in state.problems.values()]
    for key in character.skins:
        skin = key.find()
        if skin:
            lines += _skin(skin)
    return lines


def _skin(skin) -> list[str]:
    mesh = skin.data
    modifiers = ", ".join(f"{found.name} ({found.type}{'' if found.show_viewport else ', off'})" for found in skin.modifiers)
    keys = len(mesh.shape_keys.key_blocks) if mesh.shape_keys else 0
    state = session.cached_skin(skin)
    lines = [
        f"  Mesh {skin.name}: {len(mesh.vertices)} vertices, {len(mesh.polygons)} faces, {keys} shape keys, "
        f"{len(skin.vertex_groups)} vertex groups, users {mesh.users}",
        f"    modifiers: {modifiers}",
        f"    settings: {_changed(skin.sinew.skin)}",
    ]
    if state is not None:
        lines.append(f"    bound: {state.skin.anchored} vertices")
        if state.report is not None:
            lines.append(f"    last frame: {len(state.report.clamped)} at minimum length, {state.report.damped} limited")
    if session.reason(skin):
        lines.append(f"    problem: {session.reason(skin)}")
    return lines


def _changed(settings) -> str:
    """The settings that differ from their defaults, as text."""
    changed = []
    for found in settings.bl_rna.properties:
        if found.is_readonly or found.type in ("POINTER", "COLLECTION") or not settings.is_property_set(found.identifier):
            continue
        value = getattr(settings, found.identifier)
        if found.type == "STRING":
            value = f"{len(value)} characters"
        elif getattr(found, "is_array", False):
            value = tuple(value)
        elif value == found.default:
            continue
        changed.append(f"{found.identifier}={value:g}" if isinstance(value, float) else f"{found.identifier}={value}")
    return ", ".join(changed) or "defaults"
