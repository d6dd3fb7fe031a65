"""Measures of single places: how far a crease stays open, and how far muscles raise the skin."""

import bpy
import numpy as np
from bl_ext.user_default.sinew.live import session
from bl_ext.user_default.sinew.scene import characters
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from benchmarks import quality_poses
from benchmarks.quality_character import SINEW, Character

CREASES = (("elbow", 120), ("elbow", 150), ("knee", 140), ("hip", 110))
FACING = -0.8  # cosine of two normals that face each other
FARTHEST_M = 0.03
CLEAR_M = 1e-6
CARRIED_FROM = 0.2  # influence of a group of muscles from which a vertex counts as theirs


def crease_gap(character: Character, joint: str, points: np.ndarray) -> tuple[float, float] | None:
    """The smallest and the median distance of the two sides of a crease, in mm; None if no skin faces the other side.

    The distance is measured along the normals, from skin below the joint to facing skin above it, up to 30 mm.
    """
    hinge = quality_poses.hinge_of(character.rig, joint)
    below = character.weight_below(hinge.bone)
    triangles = character.triangles[character.region(joint).faces]
    side = below[triangles].mean(axis=1)
    lower, upper = triangles[side > 0.5], triangles[side < 0.5]
    tree = BVHTree.FromPolygons(points.tolist(), upper.tolist(), all_triangles=True)
    gaps = []
    for triangle in lower:
        a, b, c = (Vector(points[corner]) for corner in triangle)
        normal = (b - a).cross(c - a).normalized()
        _, other, _, distance = tree.ray_cast((a + b + c) / 3.0 + CLEAR_M * normal, normal, FARTHEST_M)
        if other is not None and other.dot(normal) < FACING:
            gaps.append(1000.0 * distance)
    return (float(np.min(gaps)), float(np.median(gaps))) if gaps else None


def rises(character: Character) -> dict[str, dict[str, tuple[float, float]]]:
    """How far each group of muscles raises the skin, as mean and largest distance in mm: relaxed, and with full tension.

    The distance is from the same elastic skin at Muscle Influence 0, along the normals, over the vertices of these muscles.
    """
    points = {gain: _points_by_tension(character, gain) for gain in (1.0, 0.0)}
    character.skin.sinew.skin.muscle_influence = 1.0
    bpy.context.view_layer.update()
    result = {}
    for name in quality_poses.RISES:
        carried = _carried(character, name)
        result[name] = {}
        for state in ("relaxed", "tense"):
            with_muscles, without = points[1.0][name, state], points[0.0][name, state]
            rise = np.einsum("ij,ij->i", with_muscles - without, _normals(character, without))[carried]
            result[name][state] = (1000.0 * float(rise.mean()), 1000.0 * float(rise.max()))
    return result


def _points_by_tension(character: Character, gain: float) -> dict[tuple[str, str], np.ndarray]:
    character.skin.sinew.skin.muscle_influence = gain
    points = {}
    for name, ((joint, degrees), _) in quality_poses.RISES.items():
        for state, tension in (("relaxed", 0.0), ("tense", 1.0)):
            muscles = _muscles(character, name)
            for muscle in muscles:
                muscle.sinew.tissue.tension = tension
            character.pose(quality_poses.both(**{joint: degrees}))
            points[name, state] = character.points(SINEW).astype(np.float64)
            for muscle in muscles:
                muscle.sinew.tissue.tension = 0.0
    return points


def _muscles(character: Character, name: str) -> list:
    starts = quality_poses.RISES[name][1]
    return [found for found in characters.tissues_of(character.rig) if found.name.startswith(starts)]


def _carried(character: Character, name: str) -> np.ndarray:
    chosen = {muscle.name for muscle in _muscles(character, name)}
    tissues = characters.tissues_of(character.rig)
    solved = [tissues[index].name for index in session.cached_rig(character.rig).solved]
    weights = session.cached_skin(character.skin).skin.tissue_weights
    return weights[:, [tissue in chosen for tissue in solved]].sum(axis=1) > CARRIED_FROM


def _normals(character: Character, points: np.ndarray) -> np.ndarray:
    """(vertices, 3): unit normals, weighted by the areas of the triangles."""
    a, b, c = (points[character.triangles[:, corner]] for corner in range(3))
    normals = np.zeros_like(points)
    for corner in range(3):
        np.add.at(normals, character.triangles[:, corner], np.cross(b - a, c - a))
    return normals / np.maximum(np.linalg.norm(normals, axis=1), 1e-30)[:, None]
