"""Measures how tissues fill a body; see scripts/fill.py.

usage: scripts/run_in_blender.py scripts/benchmarks/fill_in_blender.py OPTIONS, a JSON object
"""

import json
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
from bl_ext.user_default.sinew.live import ellipsoids, session
from bl_ext.user_default.sinew.muscles import portable_names
from bl_ext.user_default.sinew.muscles.placing.fit.skin_surface import SkinSurface
from bl_ext.user_default.sinew.muscles.placing.recognise import segments
from bl_ext.user_default.sinew.scene import characters
from bl_ext.user_default.sinew.skin.main_skin import skins_to_fit

from benchmarks import leg_muscles
from benchmarks.recognition_table import load

BODY = "makehuman"
SPACING_M = 0.009  # of a body 1.7 m tall
# the parts of the body whose fat layer is measured: the trunk and the limbs without hands and feet
TRUNK_AND_LIMBS = ("abdomen", "chest", "upper_arm", "forearm", "thigh", "shin")
DEEPEST_M = 0.08  # a ray that has met no tissue there counts as that deep
RAYS = 3000
HEADER = (
    "| body | tissues (ellipsoids) | seconds | inside, % | in two or more, % | outside, % | depth, mm: median, 90 % "
    "| leg muscles within 0.8-1.25 | volume, l |\n|---|---|---|---|---|---|---|---|---|"
)


@dataclass
class Filled:
    """A body with its tissues: ellipsoids as (E, 4, 4) maps from the unit sphere, the tissue of each, and the skin."""

    rig: object
    surface: SkinSurface
    points: np.ndarray
    triangles: np.ndarray
    matrices: np.ndarray
    owners: np.ndarray
    names: list[str]
    kinds: list[str]


def filled(name: str, options: dict) -> tuple[Filled, float]:
    """The body with muscles, and the seconds that adding them took."""
    if name == BODY:
        from data import body_in_blender

        bpy.ops.wm.read_factory_settings(use_empty=True)
        _mesh, rig = body_in_blender.build()
    else:
        rig = load(Path(name))
    bpy.context.view_layer.objects.active = rig
    start = time.perf_counter()
    bpy.ops.sinew.add_preset(name=options["preset"], **options["operator"])
    seconds = time.perf_counter() - start
    bpy.context.view_layer.update()
    skins = skins_to_fit(rig)
    points, triangles = _triangles(skins, rig)
    state = session.cached_rig(rig)
    found = ellipsoids.of(state)
    solved = [characters.tissues_of(rig)[index] for index in state.solved]
    portable = {empty: portable_name for portable_name, empty in portable_names.of_rig(rig).items()}
    return (
        Filled(
            rig,
            SkinSurface.of_all(skins, rig),
            points,
            triangles,
            found.matrices.transpose(0, 2, 1).astype(float),
            np.asarray(found.owners),
            [portable[empty] for empty in solved],
            [empty.sinew.tissue.kind for empty in solved],
        ),
        seconds,
    )


def _triangles(skins: list, rig) -> tuple[np.ndarray, np.ndarray]:
    points, triangles, count = [], [], 0
    for skin in skins:
        to_rig = rig.matrix_world.inverted() @ skin.matrix_world
        mesh = skin.data
        mesh.calc_loop_triangles()
        points.append(np.array([to_rig @ vertex.co for vertex in mesh.vertices]))
        triangles.append(np.array([triangle.vertices for triangle in mesh.loop_triangles]) + count)
        count += len(mesh.vertices)
    return np.concatenate(points), np.concatenate(triangles)


def grid(body: Filled) -> tuple[np.ndarray, np.ndarray, float]:
    """Points on a grid around the body, whether each is inside, and the volume of a cell, m3."""
    low, high = body.points.min(0), body.points.max(0)
    spacing = SPACING_M * (high - low).max() / 1.7
    counts = np.ceil((high - low) / spacing).astype(int)
    axes = [start + spacing * (np.arange(count) + 0.5) for start, count in zip(low, counts)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)
    return points, body.surface.core.are_inside(points), spacing**3


def tissues_around(points: np.ndarray, body: Filled) -> np.ndarray:
    """(points,): the number of tissues that each point is in. The ellipsoids of one tissue count once."""
    counts = np.zeros(len(points), np.int32)
    inverses = np.linalg.inv(body.matrices)
    for owner in np.unique(body.owners):
        is_in = np.zeros(len(points), bool)
        for index in np.flatnonzero(body.owners == owner):
            centre, reach = body.matrices[index, :3, 3], np.linalg.norm(body.matrices[index, :3, :3], axis=0).max()
            near = np.flatnonzero((np.abs(points - centre) < reach).all(1))
            local = points[near] @ inverses[index, :3, :3].T + inverses[index, :3, 3]
            is_in[near[(local**2).sum(1) < 1]] = True
        counts += is_in
    return counts


def depths(body: Filled) -> dict[str, np.ndarray]:
    """By role: distances from the skin inwards, along its normal, to the first tissue, m."""
    triangle = body.points[body.triangles]
    normals = np.cross(triangle[:, 1] - triangle[:, 0], triangle[:, 2] - triangle[:, 0])
    areas = np.linalg.norm(normals, axis=1)
    order = np.cumsum(areas) / areas.sum()
    chosen = np.searchsorted(order, (np.arange(RAYS) + 0.5) / RAYS)
    starts, inward = triangle[chosen].mean(1), -normals[chosen] / areas[chosen, None]
    inverses = np.linalg.inv(body.matrices)
    nearest = np.full(RAYS, DEEPEST_M)
    for inverse in inverses:
        origin = starts @ inverse[:3, :3].T + inverse[:3, 3]
        direction = inward @ inverse[:3, :3].T
        a, b, c = (direction**2).sum(1), (origin * direction).sum(1), (origin**2).sum(1) - 1
        root = b * b - a * c
        hits = root > 0
        entry = (-b - np.sqrt(np.where(hits, root, 0))) / a
        leaves = (-b + np.sqrt(np.where(hits, root, 0))) / a
        depth = np.where(entry > 0, entry, 0.0)
        hits &= leaves > 0
        nearest[hits] = np.minimum(nearest[hits], depth[hits])
    recognised = segments.recognise(body.rig)
    roles = _roles(starts, recognised)
    return {role: nearest[roles == role] for role in TRUNK_AND_LIMBS}


def _roles(points: np.ndarray, body) -> np.ndarray:
    """(points,): the role of the nearest segment of the body."""
    found, nearest = np.full(len(points), "", dtype=object), np.full(len(points), np.inf)
    for segment in body.segments.values():
        start, end = np.array(segment.start), np.array(segment.end)
        along = np.clip((points - start) @ (end - start) / max(segment.length**2, 1e-12), 0, 1)
        distance = np.linalg.norm(points - start - along[:, None] * (end - start), axis=1)
        closer = distance < nearest
        nearest[closer], found[closer] = distance[closer], segment.role
    return found


def volumes(body: Filled) -> dict[str, float]:
    """By name: the volume of each tissue, m3. Of a curved muscle, that of the ellipsoid that its chain is inscribed in."""
    state = session.cached_rig(body.rig)
    posed = state.musculature.pose(state.pose, state.tension, state.posed)
    return dict(zip(body.names, posed.volume.tolist()))


def row(name: str, options: dict) -> str:
    """One row of the table; with `details`, lines below it."""
    body, seconds = filled(name, options)
    points, inside, cell = grid(body)
    counts = tissues_around(points, body)
    volume = inside.sum() * cell
    depth = depths(body)
    every = 1000 * np.concatenate(list(depth.values()))
    share = lambda mask: 100 * mask.sum() / inside.sum()  # noqa: E731
    ratios = leg_muscles.ratios(volumes(body), volume)
    good = sum(0.8 <= ratio <= 1.25 for ratio in ratios.values())
    line = (
        f"| {Path(name).stem} | {len(body.names)} ({len(body.owners)}) | {seconds:.2f} | {share(inside & (counts > 0)):.1f} "
        f"| {share(inside & (counts > 1)):.1f} | {share(~inside & (counts > 0)):.2f} "
        f"| {np.median(every):.1f}, {np.percentile(every, 90):.1f} | {good} of {len(ratios)} | {1000 * volume:.1f} |"
    )
    if options["details"]:
        print(line)
        for role, found in depth.items():
            print(f"    {role}: depth {1000 * np.median(found):.1f}, {1000 * np.percentile(found, 90):.1f} mm")
        roles = _roles(points, segments.recognise(body.rig))
        for role in sorted(set(roles)):
            of = inside & (roles == role)
            if of.any():
                in_one, in_two = (100 * (of & (counts > number)).sum() / of.sum() for number in (0, 1))
                print(f"    {role}: {1000 * of.sum() * cell:.1f} l, inside {in_one:.1f} %, in two or more {in_two:.1f} %")
        for muscle, ratio in sorted(ratios.items(), key=lambda item: item[1]):
            print(f"    {muscle}: {ratio:.2f}")
    return line


def main() -> None:
    options = json.loads(sys.argv[1])
    lines = [row(name, options) for name in options["bodies"]]
    print(HEADER, *lines, sep="\n")


if __name__ == "__main__":
    main()
