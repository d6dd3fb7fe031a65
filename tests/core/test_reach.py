"""Reaching through the binding: arguments are checked, and solutions are right and repeatable."""

import _sinew
import numpy as np
import pytest
from conftest import rotation, translation


def chain(count=3, length=0.3, **changes):
    """A chain of ball joints along y, slightly bent."""
    sockets = [translation((0, length if joint else 0, 0)) @ rotation((1, 0, 0.2), 0.1 * joint) for joint in range(count)]
    arguments = {
        "names": [f"bone {joint}" for joint in range(count)],
        "parents": np.arange(-1, count - 1, dtype=np.int32),
        "sockets": np.ascontiguousarray(np.swapaxes(np.array(sockets), 1, 2)),
        "parameterisations": ["BALL"] * count,
        "angles": np.zeros((count, 3)),
        "lower": np.full((count, 3), -3.0),
        "upper": np.full((count, 3), 3.0),
    }
    return _sinew.Linkage(**arguments | changes)


END = (0.0, 0.3, 0.0)


def test_a_goal_is_reached_and_heads_agree_with_the_pose():
    linkage = chain()
    goal = _sinew.Goal(2, "POSITION", (0.2, 0.4, 0.3), point=END)
    found = _sinew.reach(linkage, [goal])
    assert found.misses[0] < 1e-4 and found.evaluations > 0
    assert found.angles.shape == (3, 3)
    head_of_last = linkage.heads(found.angles)[2]
    assert np.linalg.norm(head_of_last - (0.2, 0.4, 0.3)) == pytest.approx(0.3, abs=1e-4)
    assert (len(linkage), linkage.freedom_count) == (3, 9)


def test_reaching_twice_gives_the_same_bits():
    goal = _sinew.Goal(2, "POSITION", (0.9, 0.4, 0.3), point=END)
    angles = [_sinew.reach(chain(), [goal], restarts=4).angles.tobytes() for _ in range(3)]
    assert len(set(angles)) == 1


def test_locks_and_limits_are_kept():
    lower, upper = np.full((3, 3), -0.2), np.full((3, 3), 0.3)
    lower[1] = upper[1] = (0.1, 0.0, -0.1)
    linkage = chain(parameterisations=["SWING_TWIST", "XYZ", "ZYX"], lower=lower, upper=upper)
    assert linkage.freedom_count == 6
    assert linkage.angles[1].tolist() == [0.1, 0.0, -0.1]
    found = _sinew.reach(linkage, [_sinew.Goal(2, "POSITION", (3, -1, 2), point=END)], restarts=2)
    assert (found.angles >= lower).all() and (found.angles <= upper).all()


def test_orientation_and_look_at():
    turned = np.array((0.9, 0.1, -0.3, 0.2)) / np.linalg.norm((0.9, 0.1, -0.3, 0.2))
    found = _sinew.reach(chain(), [_sinew.Goal(2, "ORIENTATION", turned)])
    assert found.misses[0] < 1e-4
    found = _sinew.reach(chain(), [_sinew.Goal(1, "LOOK_AT", (3, 0, 4), axis=(0, 0, 1))])
    assert found.misses[0] < 1e-4


def test_a_clip_is_solved_frame_by_frame():
    goals = [[_sinew.Goal(2, "POSITION", (0.2 + 0.01 * frame, 0.4, 0.3), point=END)] for frame in range(6)]
    frames = _sinew.reach_clip([chain() for _ in goals], goals, smoothness=0.001)
    assert len(frames) == 6 and max(frame.misses[0] for frame in frames) < 1e-3
    assert np.abs(np.diff([frame.angles for frame in frames], axis=0)).max() < 0.1
    with pytest.raises(ValueError, match="goals: expected 6 entries, one per linkage, got 5"):
        _sinew.reach_clip([chain() for _ in goals], goals[:5])


@pytest.mark.parametrize("parameterisation", ["BALL", "SWING_TWIST", "XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"])
def test_angles_and_rotations_convert_both_ways(parameterisation):
    angles = (0.4, -0.7, 1.1)
    turned = _sinew.joint_rotation(parameterisation, angles)
    assert np.linalg.norm(turned) == pytest.approx(1.0)
    assert _sinew.joint_angles(parameterisation, turned, angles) == pytest.approx(angles, abs=1e-9)
    assert _sinew.joint_angles(parameterisation, [-part for part in turned], angles) == pytest.approx(angles, abs=1e-9)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"parents": np.array([0, 0, 1], np.int32)}, "parents: entry 0 is 0"),
        (
            {"parameterisations": ["BALL", "BALL", "HINGE"]},
            "parameterisations: expected BALL, SWING_TWIST or an order such as XYZ, got",
        ),
        ({"parameterisations": ["BALL"]}, "parameterisations: expected 3 entries, one per name, got 1"),
        ({"angles": np.zeros((3, 3), np.float32)}, "angles: expected float64 array"),
        ({"lower": np.full((3, 3), 4.0)}, 'Limits of joint "bone 0"'),
        ({"eagerness": np.array([1.0, 5.0, 1.0])}, 'Eagerness of joint "bone 1"'),
        ({"sockets": np.zeros((3, 4, 4))}, 'that of "bone 0" is not affine'),
        ({"scales": np.zeros((3, 3))}, 'Scale of joint "bone 0" cannot be inverted'),
        ({"names": ["a", "a", "b"]}, '"a" is the name of two joints'),
    ],
)
def test_impossible_chains_are_refused_by_name(changes, message):
    with pytest.raises(ValueError) as refusal:
        chain(**changes)
    assert message in str(refusal.value)


def test_impossible_goals_are_refused_by_name():
    with pytest.raises(ValueError, match="kind: expected POSITION, ORIENTATION or LOOK_AT"):
        _sinew.Goal(0, "THERE", (0, 0, 0))
    with pytest.raises(ValueError, match="target: expected a quaternion"):
        _sinew.Goal(0, "ORIENTATION", (0, 0, 0, 0))
    with pytest.raises(ValueError, match="goals: entry 0 is 7, outside 0..3"):
        _sinew.reach(chain(), [_sinew.Goal(7, "POSITION", (0, 0, 0))])
    with pytest.raises(ValueError, match="weight: expected a number from 0 to 1e18, got -1"):
        _sinew.Goal(0, "POSITION", (0, 0, 0), weight=-1.0)
    with pytest.raises(ValueError, match="preferred: expected float64 array"):
        _sinew.reach(chain(), [], np.zeros((2, 3)))
