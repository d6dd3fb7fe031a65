"""The elastic skin through the binding."""

import os
import subprocess
import sys
from pathlib import Path

import _sinew
import numpy as np
import pytest
from conftest import elasticity_of, make_limb, rotation, translation


def elastic(limb, iterations=10, **changes):
    return limb.skin(elasticity=_sinew.Elasticity(**elasticity_of(limb, **changes), iterations=iterations))


def deformed(limb, skin, pose):
    out = limb.out()
    skin.deform(pose, limb.relaxed, out)
    return out.astype(np.float64)


def volume(limb, points):
    """The volume of the tube, closed by fans at its open ends."""
    corners = (points - points.mean(axis=0))[limb.triangles]
    total = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    rings = points.reshape(24, 16, 3) - points.mean(axis=0)
    for ring, sign in ((rings[0], 1.0), (rings[-1], -1.0)):
        hub = ring.mean(axis=0)
        total += sign * np.einsum("ij,ij->", np.roll(ring, -1, axis=0), np.cross(ring, hub[None]))
    return abs(total) / 6.0


def test_the_rest_pose_does_not_change(limb):
    out = limb.out()
    elastic(limb).correct(limb.rest, limb.relaxed, out)
    assert np.abs(out).max() <= 1e-6


@pytest.mark.parametrize("angle", [1.4, 1.8])
def test_a_bent_joint_keeps_its_volume(limb, angle):
    rest = volume(limb, limb.mesh["points"].astype(np.float64))
    linear = limb.skin(muscle_influence=_sinew.Regional(body=0.0))
    stiff = volume(limb, deformed(limb, linear, limb.bent(angle)))
    kept = volume(limb, deformed(limb, elastic(limb), limb.bent(angle)))
    assert abs(kept / rest - 1.0) < 0.01 < abs(stiff / rest - 1.0)


def test_the_skin_moves_with_the_whole_rig(limb):
    skin, motion = elastic(limb), translation((0.3, -0.2, 0.5)) @ rotation((1, 2, 3), 1.3)
    still = deformed(limb, skin, limb.bent(1.4))
    moved = deformed(limb, skin, limb.bent(1.4, motion))
    assert np.abs(still @ motion[:3, :3].T + motion[:3, 3] - moved).max() < 5e-6


def test_skin_far_from_bent_joints_is_as_without_elasticity(limb):
    far = np.linalg.norm(limb.mesh["points"] - (0, 0, 0.3), axis=1) > 0.3
    stiff = deformed(limb, limb.skin(), limb.bent(1.4))
    kept = deformed(limb, elastic(limb, safeguard=False), limb.bent(1.4))  # which drops the smallest offsets
    assert far.any() and np.array_equal(kept[far], stiff[far])
    assert np.abs(kept - stiff).max() > 5e-3


def test_a_frame_does_not_depend_on_earlier_frames(limb):
    skin = elastic(limb)
    first = deformed(limb, skin, limb.bent(1.4))
    deformed(limb, skin, limb.bent(-0.7))
    assert np.array_equal(deformed(limb, skin, limb.bent(1.4)), first)


def test_the_skin_follows_a_bend_without_jumps(limb):
    """A step of 0.1 degrees moves no vertex further than its lever arm allows, at rest and where the crease plane starts."""
    skin, step = elastic(limb), np.radians(0.1)
    angles = np.arange(0.0, 0.7, step)
    points = np.array([deformed(limb, skin, limb.bent(angle)) for angle in angles])
    moves = np.linalg.norm(np.diff(points, axis=0), axis=-1).max(axis=1)
    assert moves.max() < 2.0 * step * 0.35


def test_the_number_of_iterations_has_an_effect(limb):
    none = deformed(limb, elastic(limb, iterations=0), limb.bent(1.4))
    some = deformed(limb, elastic(limb, iterations=5), limb.bent(1.4))
    assert np.abs(none - some).max() > 1e-3


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"spring_edges": np.array([[0, 99999]], np.int32)}, "99999"),
        ({"triangles": np.array([[0, 1, -1]], np.int32)}, "-1"),
        ({"segments": np.zeros(3, np.int32), "bone_lengths": np.ones(3, np.float32)}, "one per bone"),
    ],
)
def test_values_that_do_not_fit_are_refused(limb, changes, words):
    with pytest.raises(ValueError, match=words):
        elastic(limb, **changes)


def test_degenerate_meshes_stay_finite(limb):
    points = limb.mesh["points"].copy()
    points[100:140] = points[100]
    mesh = limb.mesh | {"points": points}
    skin = _sinew.Skin(limb.musculature, **mesh, elasticity=_sinew.Elasticity(**elasticity_of(limb)))
    for angle in (0.5, 3.12, np.pi):
        assert np.isfinite(deformed(limb, skin, limb.bent(angle))).all()


FOLDED = 2.8
"""Rotation of the elbow at which the forearm touches the upper arm, radians."""


def folded_bytes():
    limb = make_limb(24, 60)
    out = np.empty_like(limb.mesh["points"])
    found = []
    for contacts in (True, False):
        skin = elastic(limb, contacts=contacts)
        for angle in (FOLDED, 0.4, FOLDED):
            skin.deform(limb.bent(angle), limb.relaxed, out)
            found.append(out.tobytes())
    return found


def test_skin_contact_gives_the_same_bits_on_any_number_of_threads():
    """Each thread count needs its own process, because it is read when the first frame is computed."""
    found = {}
    for threads in ("1", "2", "8"):
        program = "import sys, test_elasticity; sys.stdout.buffer.write(b''.join(test_elasticity.folded_bytes()))"
        env = os.environ | {"RAYON_NUM_THREADS": threads}
        env["PYTHONPATH"] = os.pathsep.join([str(Path(__file__).parent), env.get("PYTHONPATH", "")])
        done = subprocess.run([sys.executable, "-c", program], env=env, capture_output=True, check=True)
        found[threads] = done.stdout
    assert found["1"] and found["1"] == found["2"] == found["8"]
    frames = folded_bytes()
    assert b"".join(frames) == found["1"]
    assert frames[0] == frames[2] and frames[0] != frames[3], "contact did nothing"


@pytest.mark.parametrize("switch", ["contacts", "safeguard"])
def test_switches_are_true_or_false(limb, switch):
    for wrong in (1.5, "no", None):
        with pytest.raises(TypeError, match=switch):
            elastic(limb, **{switch: wrong})


@pytest.mark.parametrize("iterations", [-1, 1001, 2.5, None])
def test_iterations_must_be_an_integer_in_range(limb, iterations):
    with pytest.raises((ValueError, TypeError), match="iterations"):
        elastic(limb, iterations=iterations)
