# SPDX-License-Identifier: GPL-3.0-or-later
"""Baking the live skin to point caches: the saved skin positions of Wilhelms 1997, which play without any computing.

By default the points are those *before* the Armature modifier (rest pose with shape keys and correction): a Mesh Cache
modifier in the place of Sinew's gives the live picture, and the rig still poses them. The posed points, in the object's
space, are for other programs.
"""

from collections.abc import Iterator
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
from ...scene import armature_modifier, correction_modifier
from ..scratch.scratch_mesh import ScratchMesh
from . import point_cache
from .playback import turned
from .point_cache import Timing


@dataclass(frozen=True)
class CacheSettings:
    """What is written: `points` (see ScratchMesh), `file_format` (see point_cache), `up_axis`: "Z" as in Blender, or "Y"."""

    points: str
    file_format: str
    up_axis: str


class CacheBake:
    """A bake of some skins into one file each. Run through `steps`; closed before its end, nothing has changed.

    bind_frame: where the skins are bound; the first frame of all, if these are the frames of one chunk of many. Bind and
    pose decide each frame alone, so that chunks hold the same bytes as a whole bake (which no simulation in the scene
    does, unless that is baked itself).
    """

    def __init__(
        self, skins: list, scene, frames: range, settings: CacheSettings, paths: list[Path], bind_frame: int | None = None
    ):
        _check(skins, frames)
        if len({str(path).casefold() for path in paths}) < len(paths):
            names = ", ".join(skin.name for skin in skins)
            raise SinewError(f"{names}: some of their files would have the same name; rename one")
        self.skins, self.paths, self.scene = [skin.name for skin in skins], paths, scene
        self.settings = settings
        self.timing = Timing(frames, scene.render.fps / scene.render.fps_base)
        self.places: list[int] = []
        self.left_out: list[str] = []
        self.vertices: list[int] = [len(skin.data.vertices) for skin in skins]
        self._bind_frame = frames.start if bind_frame is None else bind_frame

    def steps(self) -> Iterator[float]:
        """Bakes, a frame at a step, yielding the part done, 0..1. The files are there when it ends, and not before.

        Raises SinewError where a skin can't be evaluated, NotWritten where a file can't be written.
        """
        frame_before = (self.scene.frame_current, self.scene.frame_subframe)
        live_before = {skin.name: skin.sinew.skin.live for skin in self._skins()}
        scratch_meshes: list[ScratchMesh] = []
        try:
            yield from self._bake(scratch_meshes)
        finally:
            for scratch_mesh in scratch_meshes:
                scratch_mesh.remove()
            for skin in self._skins():
                skin.sinew.skin.live = live_before[skin.name]
            frame, subframe = frame_before
            self.scene.frame_set(frame, subframe=subframe)

    def _bake(self, scratch_meshes: list[ScratchMesh]) -> Iterator[float]:
        for skin in self._skins():
            skin.sinew.skin.live = True
            session.forget_skin(skin)
        self._go_to(self._bind_frame)
        for skin in self._skins():
            scratch_meshes.append(ScratchMesh(self.scene, skin, self.settings.points))
        self.places = [scratch_mesh.place for scratch_mesh in scratch_meshes]
        self.left_out = list(dict.fromkeys(name for scratch_mesh in scratch_meshes for name in scratch_mesh.left_out))
        self._go_to(self._bind_frame)
        binds = [_live_state(skin) for skin in self._skins()]
        file_format = self.settings.file_format
        with ExitStack() as open_files:
            files = [open_files.enter_context(atomic_write(path)) for path in self.paths]
            for file, vertices in zip(files, self.vertices, strict=True):
                file.write(point_cache.head_of(file_format, self.timing, vertices))
            for done, frame in enumerate(self.timing.frames, 1):
                for skin, bind in zip(self._skins(), binds, strict=True):
                    session.pin_bind(skin, bind)
                self._go_to(frame)
                depsgraph = bpy.context.evaluated_depsgraph_get()
                for skin, scratch_mesh, file in zip(self._skins(), scratch_meshes, files, strict=True):
                    _live_state(skin)
                    points = scratch_mesh.points(depsgraph)
                    if not np.isfinite(points).all():
                        raise SinewError(f"{skin.name} is not finite in frame {frame}: check its bones' scales")
                    point_cache.write_sample(file, file_format, turned(points, self.settings.up_axis))
                yield done / len(self.timing.frames)

    def _go_to(self, frame: int):
        self.scene.frame_set(frame)
        bpy.context.view_layer.update()

    def _skins(self) -> list:
        return [bpy.data.objects[name] for name in self.skins]


def path_of(folder: Path, skin, file_format: str) -> Path:
    """Where the cache of a skin is written in a folder."""
    return folder / (stem_of(skin.name) + point_cache.SUFFIXES[file_format])


def _live_state(skin) -> SkinState:
    """The bind that the current frame was computed with. Raises SinewError where the skin was not deformed in it."""
    problem, state = session.reason(skin), session.cached_skin(skin)
    if problem or state is None:
        raise SinewError(problem or f"{skin.name} is not part of this scene and view layer: make it visible")
    return state


def _check(skins: list, frames: range):
    if not frames:
        raise SinewError(f"The last frame ({frames.stop - 1}) lies before the first ({frames.start})")
    for skin in skins:
        if not armature_modifier.is_bound(skin):
            raise SinewError(f"{skin.name} is not bound: bind it first (Bind Skin)")
        if skin.library:
            raise SinewError(
                f"{skin.name} is linked from another file and can't be made live: make a library override of it"
            )
        if skin.data.is_editmode:
            raise SinewError(f"{skin.name} is in Edit Mode: leave it (Tab) and bake again")
        if correction_modifier.modifier_of(skin) is None:
            raise SinewError(f"{skin.name}: the Sinew modifier was removed; bind again")
