"""A valid call of every class and function of `_sinew`, by name, for the generated calls."""

from collections.abc import Callable
from functools import cache

import _sinew
import numpy as np
from conftest import Limb, elasticity_of, make_limb

# each parameter of a call by name, with a valid value
Call = tuple[Callable, dict]
LIMB = make_limb(around=6, along=5)
VERTICES = len(LIMB.mesh["points"])
CUBE_POINTS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float32)
CUBE_CORNERS = np.array([0, 1, 3, 2, 4, 6, 7, 5, 0, 4, 5, 1, 2, 3, 7, 6, 0, 2, 6, 4, 1, 5, 7, 3], np.int32)
CUBE_OFFSETS = np.arange(0, 25, 4, dtype=np.int32)


def in_order(function: Callable) -> Callable:
    """A function that takes its arguments by position, called by name."""
    return lambda **named: function(*named.values())


@cache
def valid_calls() -> dict[str, Call]:
    """All calls, by what is called."""
    return (
        _skeleton_calls(LIMB) | _skin_calls(LIMB) | _bake_calls(LIMB) | _measure_calls(LIMB) | _fit_calls() | _reach_calls()
    )


def _skeleton_calls(limb: Limb) -> dict[str, Call]:
    posing = {"pose": limb.bent(0.8), "tension": limb.relaxed}
    tissue = {
        "name": "a", "kind": "MUSCLE", "origin_bone": 0, "insertion_bone": 1, "centre": (0.03, 0.0, 0.3),
        "rotation": (1.0, 0.0, 0.0, 0.0), "semi_axes": (0.02, 0.02, 0.1), "origin_tendon": 0.02, "insertion_tendon": 0.03,
    }  # fmt: skip
    shown = {
        "skeleton": limb.skeleton, "names": ["a"], "bones": np.array([0], np.int32),
        "to_bones": np.eye(4, dtype=np.float32)[None], "locations": np.zeros((1, 3), np.float32),
        "rotations": np.array([[1, 0, 0, 0]], np.float32), "scales": np.ones((1, 3), np.float32), "orders": ["XYZ"],
    }  # fmt: skip
    deltas = {"pose": limb.rest, "posed": np.eye(4, dtype=np.float32)[None], "out": np.zeros((1, 13), np.float32)}
    growing = {
        "skin_thickness": np.full(3, 0.005, np.float32), "bone_lengths": np.array([0.3, 0.3], np.float32),
        "weight_bones": np.array([0, 1], np.int32), "resolution": 20, "thickness": 0.0, "smoothing": 2, "radius": 1,
        "decay": 1.0, "faces": 60, "symmetric": False, "largest_only": False, "memory_limit_mb": 100.0,
    }  # fmt: skip
    return {
        "Skeleton": (_sinew.Skeleton, {"names": ["a", "b"], "parents": np.array([-1, 0], np.int32), "rest": limb.rest}),
        "Tissue": (in_order(_sinew.Tissue), tissue),
        "Musculature": (_sinew.Musculature, {"skeleton": limb.skeleton, "tissues": limb.tissues}),
        "Musculature.pose": (limb.musculature.pose, posing | {"out": np.zeros((3, 4, 4), np.float32)}),
        "Musculature.pose_ellipsoids": (
            limb.musculature.pose_ellipsoids,
            posing | {"out": np.zeros((limb.musculature.ellipsoid_count, 4, 4), np.float32)},
        ),
        "Musculature.path_points": (limb.musculature.path_points, {"pose": limb.bent(0.8)}),
        "Musculature.joints": (limb.musculature.joints, {}),
        "ShownTissues": (_sinew.ShownTissues, shown),
        "ShownTissues.deltas": (_sinew.ShownTissues(**shown).deltas, deltas),
        "GrownSkin": (lambda **named: _sinew.GrownSkin(limb.musculature, **named), growing),
        "Progress": (_sinew.Progress, {}),
        "Progress.cancel": (_sinew.Progress().cancel, {}),
        "nearest_on_ellipsoid": (
            _sinew.nearest_on_ellipsoid,
            {"semi_axes": (0.1, 0.2, 0.3), "points": np.array([[0.5, 0.1, 0.2], [0.0, 0.0, 0.0]])},
        ),
        "set_thread_count": (_sinew.set_thread_count, {"count": 2}),
    }


def _skin_calls(limb: Limb) -> dict[str, Call]:
    skin, out = limb.skin(), np.zeros((VERTICES, 3), np.float32)
    posing = {"pose": limb.bent(0.8), "tension": limb.relaxed, "out": out}
    linear = {name: limb.mesh[name] for name in ("points", "mesh_to_armature", "weight_offsets", "weight_bones", "weights")}
    linear_skin = _sinew.LinearSkin(limb.skeleton, *linear.values())
    poses = np.stack([limb.rest, limb.bent(0.4), limb.bent(0.8)])
    regional = {"body": 1.0, "bones": np.ones(2, np.float32), "vertices": np.ones(VERTICES, np.float32)}
    elastic = limb.skin(elasticity=_sinew.Elasticity(**elasticity_of(limb, iterations=3)))
    body = {"body": limb.skin(), "body_triangles": limb.triangles, "triangles": limb.triangles}
    return {
        "Regional": (_sinew.Regional, regional),
        "Elasticity": (_sinew.Elasticity, elasticity_of(limb) | {"iterations": 3, "energy": "SPRINGS"}),
        "Skin": (limb.skin, {"falloff": 0.1, "softness": 0.01, "gain": 1.0, "anchoring": "BLENDED"}),
        "Skin of a garment": (limb.skin, body),
        "Skin of arrays": (lambda **named: _sinew.Skin(limb.musculature, **named), dict(limb.mesh)),
        "Skin of elasticity": (
            lambda **named: limb.skin(elasticity=_sinew.Elasticity(**named)),
            elasticity_of(limb) | {"iterations": 3},
        ),
        "Skin.correct": (skin.correct, posing),
        "Skin.correct of elastic skin": (elastic.correct, posing),
        "Skin.deform": (skin.deform, posing),
        "LinearSkin": (lambda **named: _sinew.LinearSkin(limb.skeleton, *named.values()), linear),
        "LinearSkin.deform": (linear_skin.deform, {"pose": limb.bent(0.8), "offsets": np.zeros_like(out), "out": out}),
        "LinearSkin.correct": (linear_skin.correct, {"pose": limb.bent(0.8), "target": limb.mesh["points"], "out": out}),
        "LinearSkin.fit": (
            linear_skin.fit,
            {"poses": poses, "targets": np.stack([limb.mesh["points"]] * 3), "most": 4, "hold": 0.01},
        ),
    }


def _bake_calls(limb: Limb) -> dict[str, Call]:
    skin, at = limb.skin(), np.linspace(0.0, 1.2, 5)
    poses, corrections = np.stack([limb.bent(angle) for angle in at]), np.zeros((5, VERTICES, 3), np.float32)
    for pose, correction in zip(poses, corrections):
        skin.correct(pose, limb.relaxed, correction)
    samples = {"skin": skin, "poses": poses, "corrections": corrections, "at": at}
    keys = samples | {"tolerance": 1e-4, "threshold": 1e-6}
    motion_keys = _sinew.MotionKeys(**keys)
    grid = {
        "skin": skin, "first": motion_keys, "second": motion_keys, "first_at": at[[2, 4]], "second_at": at[[2, 4]],
        "poses": np.ascontiguousarray(np.broadcast_to(poses[-1], (2, 2, *poses[0].shape))),
        "corrections": np.ascontiguousarray(np.broadcast_to(corrections[-1], (2, 2, *corrections[0].shape))),
        "tolerance": 1e-5, "threshold": 0.0, "most": 3,
    }  # fmt: skip
    return {
        "KeptSamples": (_sinew.KeptSamples, samples | {"tolerances": np.full(5, 1e-4), "candidates": np.ones(5, bool)}),
        "MotionKeys": (_sinew.MotionKeys, keys | {"indices": [2, 4]}),
        "MotionKeys.correction": (motion_keys.correction, {"key": 0}),
        "CombinationKeys": (_sinew.CombinationKeys, grid),
        "CombinationKeys.correction": (_sinew.CombinationKeys(**grid).correction, {"key": 0}),
    }


def _measure_calls(limb: Limb) -> dict[str, Call]:
    points = limb.mesh["points"]
    surface = _sinew.RestSurface(points, limb.triangles)
    deformed = surface.deformed(points)
    frames = np.stack([points, 1.1 * points, 1.2 * points]).astype(np.float32)
    return {
        "RestSurface": (_sinew.RestSurface, {"points": points, "triangles": limb.triangles}),
        "RestSurface.region": (surface.region, {"centre": (0.0, 0.0, 0.3), "radius": 0.1}),
        "RestSurface.whole": (surface.whole, {}),
        "RestSurface.deformed": (surface.deformed, {"points": points}),
        "DeformedSurface.quality": (deformed.quality, {"region": surface.region((0.0, 0.0, 0.3), 0.1)}),
        "SkinMotion": (_sinew.SkinMotion, {"frames": frames, "reference": frames, "counted": np.ones(VERTICES, bool)}),
    }


def _fit_calls() -> dict[str, Call]:
    cube = {
        "points": CUBE_POINTS,
        "corners": CUBE_CORNERS,
        "face_offsets": CUBE_OFFSETS,
        "to_space": np.eye(4, dtype=np.float32),
    }
    mesh = _sinew.PolygonMesh(**cube)
    placed = {
        "kinds": ["MUSCLE"], "centres": np.zeros((1, 3)), "rotations": np.array([[1.0, 0.0, 0.0, 0.0]]),
        "semi_axes": np.array([[0.5, 0.5, 0.3]]), "tendons": np.array([[0.1, 0.1]]),
        "via_offsets": np.array([0, 1], np.int32), "via_points": np.zeros((1, 3)),
    }  # fmt: skip
    tissues, surface = _sinew.PlacedTissues(**placed), _sinew.SkinSurface([mesh])
    inside, along = np.array([[0.0, 0.0, 0.0], [0.5, 0.0, 0.0]]), np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    path = _sinew.Path(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]]))
    return {
        "PolygonMesh": (_sinew.PolygonMesh, cube),
        "PlacedTissues": (_sinew.PlacedTissues, placed),
        "SkinSurface": (_sinew.SkinSurface, {"meshes": [mesh]}),
        "SkinSurface.distances_along": (surface.distances_along, {"origins": inside, "directions": along}),
        "SkinSurface.are_inside": (surface.are_inside, {"points": inside}),
        "SkinSurface.nearest": (surface.nearest, {"points": inside}),
        "SkinSurface.fit": (surface.fit, {"tissues": tissues, "left_twins": np.array([-1], np.int32)}),
        "SkinSurface.fill": (
            surface.fill,
            {
                "tissues": tissues,
                "volumes": np.array([0.1]),
                "fat": np.array([0.01]),
                "left_twins": np.array([-1], np.int32),
            },
        ),
        "SkinSurface.protrusions": (surface.protrusions, {"tissues": tissues}),
        "SurfaceTransfer": (_sinew.SurfaceTransfer, {"old": mesh, "new": mesh, "max_distance": 0.1}),
        "SurfaceTransfer.mixed": (
            _sinew.SurfaceTransfer(mesh, mesh, 0.1).mixed,
            {"values": np.ones((24, 2), np.float32)},
        ),
        "Path": (_sinew.Path, {"points": np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]])}),
        "Path.at": (path.at, {"length": 0.5}),
        "Path.nearest_length": (path.nearest_length, {"point": (0.0, 0.1, 0.5)}),
        "nearest_on_segment": (
            in_order(_sinew.nearest_on_segment),
            {"point": (0.5, 3.0, 0.0), "start": (0.0, 0.0, 0.0), "end": (2.0, 0.0, 0.0)},
        ),
    }


def _reach_calls() -> dict[str, Call]:
    sockets = np.stack([np.eye(4), np.eye(4)])
    sockets[1, 3, 1] = 0.3  # column-major: 0.3 m along y
    linkage = {
        "names": ["a", "b"], "parents": np.array([-1, 0], np.int32), "sockets": sockets,
        "parameterisations": ["BALL", "XYZ"], "angles": np.zeros((2, 3)), "lower": np.full((2, 3), -1.0),
        "upper": np.full((2, 3), 1.0), "scales": np.ones((2, 3)), "eagerness": np.ones(2), "turns_with_parent": [True, True],
    }  # fmt: skip
    goal = {
        "joint": 1, "kind": "POSITION", "target": (0.1, 0.4, 0.1), "point": (0.0, 0.3, 0.0), "axis": (0.0, 1.0, 0.0),
        "weight": 1.0,
    }  # fmt: skip
    chain, goals = _sinew.Linkage(**linkage), [_sinew.Goal(**goal)]
    clip = {"linkages": [chain, chain], "goals": [goals, goals], "preference": 1e-3, "restarts": 0, "smoothness": 0.01}
    return {
        "Linkage": (_sinew.Linkage, linkage),
        "Linkage.heads": (chain.heads, {"angles": np.zeros((2, 3))}),
        "Goal": (_sinew.Goal, goal),
        "reach": (
            _sinew.reach,
            {"linkage": chain, "goals": goals, "preferred": np.zeros((2, 3)), "preference": 1e-3, "restarts": 1},
        ),
        "reach of a goal": (lambda **named: _sinew.reach(chain, [_sinew.Goal(**named)]), goal),
        "reach_clip": (_sinew.reach_clip, clip),
        "joint_rotation": (_sinew.joint_rotation, {"parameterisation": "XYZ", "angles": (0.1, 0.2, 0.3)}),
        "joint_angles": (
            _sinew.joint_angles,
            {"parameterisation": "XYZ", "rotation": (1.0, 0.0, 0.0, 0.0), "near": (0.0, 0.0, 0.0)},
        ),
    }
