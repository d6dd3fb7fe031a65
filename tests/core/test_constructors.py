"""Constructors refuse impossible values, and objects are frozen."""

import _sinew
import numpy as np
import pytest
from conftest import make_limb

GOOD = {
    "name": "biceps",
    "kind": "MUSCLE",
    "origin_bone": 0,
    "insertion_bone": 1,
    "centre": (0, 0, 0),
    "rotation": (1, 0, 0, 0),
    "semi_axes": (0.01, 0.02, 0.1),
}


def frozen_objects():
    limb = make_limb(6, 4)
    skin = limb.skin()
    out = np.zeros((3, 4, 4), np.float32)
    posed = limb.musculature.pose(limb.rest, limb.relaxed, out)
    report = skin.correct(limb.rest, limb.relaxed, np.zeros((24, 3), np.float32))
    surface = _sinew.RestSurface(limb.mesh["points"], limb.triangles)
    deformed, region = surface.deformed(limb.mesh["points"]), surface.whole()
    motion = _sinew.SkinMotion(np.zeros((3, 4, 3), np.float32), np.zeros((3, 4, 3), np.float32))
    measuring = [surface, deformed, region, deformed.quality(region), motion]
    return [limb.skeleton, limb.tissues[0], limb.musculature, posed, skin, report, *measuring]


@pytest.mark.parametrize("thing", frozen_objects(), ids=lambda thing: type(thing).__name__)
def test_attributes_cannot_be_assigned(thing):
    for name in (*(name for name in dir(thing) if not name.startswith("_")), "other"):
        with pytest.raises(AttributeError):
            setattr(thing, name, 1)
        with pytest.raises(AttributeError):
            delattr(thing, name)
    with pytest.raises(TypeError):
        type("Own", (type(thing),), {})


def test_lengths():
    limb = make_limb(6, 4)
    assert (len(limb.skeleton), len(limb.musculature), len(limb.skin())) == (2, 3, 24)


def test_the_arrays_of_a_pose_are_read_only(limb):
    posed = limb.musculature.pose(limb.rest, limb.relaxed, np.zeros((3, 4, 4), np.float32))
    assert posed.stretch.dtype == np.float32 and posed.volume.dtype == np.float64
    for array in (posed.stretch, posed.volume):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1


@pytest.mark.parametrize(
    ("name", "value", "named"),
    [
        ("origin_bone", -1, "origin bone"), ("insertion_bone", -7, "insertion bone"),
        ("semi_axes", (0.01, 0, 0.1), "semi-axis"), ("semi_axes", (0.01, -1, 0.1), "semi-axis"),
        ("rotation", (0, 0, 0, 0), "rotation"), ("origin_tendon", -0.1, "origin tendon"),
        ("insertion_tendon", -0.2, "insertion tendon"), ("volume_keeping", 1.51, "volume keeping"),
        ("volume_keeping", -0.1, "volume keeping"), ("kind", "BONE", "rigid"),
    ],
)  # fmt: skip
def test_an_impossible_tissue_is_refused_by_name(name, value, named):
    with pytest.raises(_sinew.SinewError, match=named) as caught:
        _sinew.Tissue(**{**GOOD, name: value})
    assert "biceps" in str(caught.value)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("kind", "muscle"), ("centre", (0, 0)), ("centre", (0, 0, 0, 0)), ("centre", None), ("centre", "abc"),
        ("centre", (0, 0, float("nan"))), ("rotation", (1, 0, 0)), ("semi_axes", (1, 2, "3")),
        ("semi_axes", 1.0), ("semi_axes", (1, 2, float("inf"))),
    ],
)  # fmt: skip
def test_a_malformed_argument_is_refused_by_name(name, value):
    with pytest.raises(ValueError, match=f"^{name}: expected"):
        _sinew.Tissue(**{**GOOD, name: value})


def test_vectors_may_be_lists_or_arrays():
    semi_axes = _sinew.Tissue(**GOOD).volume
    assert _sinew.Tissue(**{**GOOD, "semi_axes": np.array([0.01, 0.02, 0.1])}).volume == semi_axes
    assert _sinew.Tissue(**{**GOOD, "semi_axes": [0.01, 0.02, 0.1]}).volume == semi_axes


def test_volumes():
    ball = 4 / 3 * np.pi
    sphere = _sinew.Tissue("s", "SPHERE", 0, 0, (0, 0, 0), (1, 0, 0, 0), (0.1, 0.2, 0.3))
    assert sphere.volume == pytest.approx(ball * 0.006)
    bone = _sinew.Tissue("b", "BONE", 0, 0, (0, 0, 0), (1, 0, 0, 0), (0.1, 0.2, 1.0))
    assert bone.volume == pytest.approx(ball * (0.06 * 0.12 * 1.0 + 2 * 0.1 * 0.2 * 0.2))
    stub = _sinew.Tissue("b", "BONE", 0, 0, (0, 0, 0), (1, 0, 0, 0), (0.1, 0.2, 0.2))
    assert stub.volume == pytest.approx(ball * (0.06 * 0.12 * 0.2 + 2 * 0.1 * 0.2 * 0.1))


def test_a_musculature_refuses_unknown_bones_and_repeated_names(limb):
    far = _sinew.Tissue(**{**GOOD, "insertion_bone": 2})
    with pytest.raises(_sinew.SinewError, match="biceps.*insertion.*2"):
        _sinew.Musculature(limb.skeleton, [far])
    twin = _sinew.Tissue(**GOOD)
    with pytest.raises(_sinew.SinewError, match="biceps.*two tissues"):
        _sinew.Musculature(limb.skeleton, [twin, twin])


@pytest.mark.parametrize(
    ("name", "value", "named"),
    [
        ("skinning", "linear", "skinning"), ("anchoring", "ALL", "anchoring"), ("motion_source", "", "motion_source"),
        ("falloff", -1.0, "falloff"), ("falloff", float("nan"), "falloff"), ("softness", 0.0, "softness"),
        ("gain", -0.5, "gain"), ("gain", float("inf"), "gain"),
    ],
)  # fmt: skip
def test_an_impossible_option_is_refused_by_name(limb, name, value, named):
    with pytest.raises(ValueError, match=named):
        limb.skin(**{name: value})


def test_sinew_error_is_a_value_error():
    assert issubclass(_sinew.SinewError, ValueError)
    assert _sinew.SinewError.__module__ == "_sinew"
    assert _sinew.__version__ == "0.2.0"


@pytest.mark.parametrize("count", [-1, -(2**40), 10**6])
def test_an_impossible_thread_count_is_refused(count):
    with pytest.raises(ValueError, match="count"):
        _sinew.set_thread_count(count)
