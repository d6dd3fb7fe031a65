# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes the live skin to point caches, which play without any computation (the saved skin positions of Wilhelms 1997).

By default the points are those before the Armature modifier: the rest pose with shape keys and correction. A Mesh Cache
modifier in the position of Sinew's then gives the live picture, and the rig still poses the points. Posed points, in
object space, are for other programs.
"""

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np

from ...errors import SinewError
from ...files.atomic_write import atomic_write
from ...files.file_names import stem_of
from ...live import session
from ...live.skin_cache import SkinState
from ...scene import correction_modifier, live_switch
from ...scene.current_frame import visit_frames
from ...scene.lookup import objects_named
from .. import requirements
from ..scratch.scratch_mesh import ScratchMesh
from . import point_cache
from .playback import to_up_axis
from .point_cache import Timing


@dataclass(frozen=True)
class CacheSettings:
    """The kind of points (see ScratchMesh), the file format (see point_cache), and the file's up axis, "Z" or "Y"."""

    points: str
    file_format: str
    up_axis: str


class CacheBake:
    """A bake of skins to one file each. If the generator of `steps` is closed before its end, nothing has changed.

    bind_frame: the frame in which the skins are bound; for a chunk, the first frame of the whole bake. A frame depends
    only on bind and pose, so chunks have the same bytes as a whole bake. Simulations in the scene break this rule,
    unless they are baked first.
    """

    def __init__(
        self, skins: list, scene, frames: range, settings: CacheSettings, paths: list[Path], bind_frame: int | None = None
    ):
        _check(skins, frames)
        if len({str(path).casefold() for path in paths}) < len(paths):
            names = ", ".join(skin.name for skin in skins)
            raise SinewError(f"{names}: two of their files would have the same name; rename one of the meshes")
        self.skins, self.paths, self.scene = [skin.name for skin in skins], paths, scene
        self.settings = settings
        self.timing = Timing(frames, scene.render.fps / scene.render.fps_base)
        self.modifier_counts: list[int] = []
        self.left_out: list[str] = []
        self.vertices: list[int] = [len(skin.data.vertices) for skin in skins]
        self._bind_frame = frames.start if bind_frame is None else bind_frame

    def steps(self) -> Iterator[float]:
        """Bakes one frame per step and yields the fraction done, 0..1. The files exist only when it has ended.

        Raises SinewError if a skin can't be evaluated, NotWritten if a file can't be written.
        """
        live_before = live_switch.switches_of(self._skins())
        scratch_meshes: list[ScratchMesh] = []
        with visit_frames(self.scene) as go_to:
            try:
                yield from self._bake(scratch_meshes, go_to)
            finally:
                for scratch_mesh in scratch_meshes:
                    scratch_mesh.remove()
                live_switch.restore_switches(live_before)

    def _bake(self, scratch_meshes: list[ScratchMesh], go_to: Callable[[float], None]) -> Iterator[float]:
        for skin in self._skins():
            skin.sinew.skin.live = True
            session.forget_skin(skin)
        go_to(self._bind_frame)
        for skin in self._skins():
            scratch_meshes.append(ScratchMesh(self.scene, skin, self.settings.points))
        self.modifier_counts = [scratch_mesh.modifier_count for scratch_mesh in scratch_meshes]
        self.left_out = list(dict.fromkeys(name for scratch_mesh in scratch_meshes for name in scratch_mesh.left_out))
        go_to(self._bind_frame)
        binds = [_live_state(skin) for skin in self._skins()]
        file_format = self.settings.file_format
        with ExitStack() as open_files:
            files = [open_files.enter_context(atomic_write(path)) for path in self.paths]
            for file, vertices in zip(files, self.vertices, strict=True):
                file.write(point_cache.header_of(file_format, self.timing, vertices))
            for done, frame in enumerate(self.timing.frames, 1):
                for skin, bind in zip(self._skins(), binds, strict=True):
                    session.pin_bind(skin, bind)
                go_to(frame)
                depsgraph = bpy.context.evaluated_depsgraph_get()
                for skin, scratch_mesh, file in zip(self._skins(), scratch_meshes, files, strict=True):
                    _live_state(skin)
                    points = scratch_mesh.points(depsgraph)
                    if not np.isfinite(points).all():
                        raise SinewError(f"{skin.name} is not finite in frame {frame}: check its bones' scales")
                    point_cache.write_sample(file, file_format, to_up_axis(points, self.settings.up_axis))
                yield done / len(self.timing.frames)

    def _skins(self) -> list:
        return objects_named(self.skins, "bake again")


def path_of(folder: Path, skin, file_format: str) -> Path:
    """The path of a skin's cache in a folder."""
    return folder / (stem_of(skin.name) + point_cache.SUFFIXES[file_format])


def _live_state(skin) -> SkinState:
    """Returns the state that deformed the skin in the current frame. Raises SinewError if the skin was not deformed."""
    problem, state = session.reason(skin), session.cached_skin(skin)
    if problem or state is None:
        raise SinewError(problem or f"{skin.name} is not part of this scene and view layer: make it visible")
    return state


def _check(skins: list, frames: range):
    requirements.require_frames(frames.start, frames.stop - 1)
    for skin in skins:
        requirements.require_bound(skin)
        if skin.library:
            raise SinewError(
                f"{skin.name} is linked from another file and can't be made live: make a library override of it"
            )
        requirements.require_object_mode(skin)
        if correction_modifier.modifier_of(skin) is None:
            raise SinewError(f"{skin.name}: the Sinew modifier was removed; bind again")
