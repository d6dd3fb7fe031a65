"""Every bad array for every argument is a ValueError that names the argument, and writes nothing."""

import _sinew
import numpy as np
import pytest
from conftest import column_major, elasticity_of, make_limb

LIMB = make_limb(8, 6)
SKIN = LIMB.skin()
VERTICES = len(SKIN)
STRENGTHS = ("volume", "crease", "contact")


def frame_arguments(last):
    return {"pose": LIMB.bent(0.5), "tension": LIMB.relaxed, "out": last}


def shown_arguments():
    ones = np.ones((3, 3), np.float32)
    return {
        "bones": np.array([0, 1, 0], np.int32), "to_bones": np.stack(3 * [np.eye(4, dtype=np.float32)]),
        "locations": ones, "rotations": np.ones((3, 4), np.float32), "scales": ones,
    }  # fmt: skip


def shown_tissues(orders=("XYZ", "ZXY", "YXZ"), **arrays):
    return _sinew.ShownTissues(LIMB.skeleton, ["a", "b", "c"], **arrays, orders=orders)


def calls():
    """Each callable and its array arguments, all valid."""
    skin_out = np.full((VERTICES, 3), 7.0, np.float32)
    tissue_out = np.full((len(LIMB.tissues), 4, 4), 7.0, np.float32)
    return {
        "Skeleton": (
            lambda **arrays: _sinew.Skeleton(["a", "b"], **arrays),
            {"parents": np.array([-1, 0], np.int32), "rest": LIMB.rest},
        ),
        "Skin": (lambda **arrays: _sinew.Skin(LIMB.musculature, **arrays), dict(LIMB.mesh)),
        "Elasticity": (_sinew.Elasticity, elasticity_of(LIMB) | {name: np.ones(2, np.float32) for name in STRENGTHS}),
        "Regional": (
            lambda **arrays: LIMB.skin(muscle_influence=_sinew.Regional(1.0, **arrays)),
            {"bones": np.ones(2, np.float32), "vertices": np.ones(VERTICES, np.float32)},
        ),
        "ShownTissues": (lambda **arrays: shown_tissues(**shown_arguments() | arrays), shown_arguments()),
        "pose": (LIMB.musculature.pose, frame_arguments(tissue_out)),
        "deltas": (
            shown_tissues(**shown_arguments()).deltas,
            {
                "pose": LIMB.bent(0.5),
                "posed": np.stack(3 * [np.eye(4, dtype=np.float32)]),
                "out": np.full((3, 13), 7.0, np.float32),
            },
        ),
        "correct": (SKIN.correct, frame_arguments(skin_out)),
        "deform": (SKIN.deform, frame_arguments(skin_out)),
        "nearest_on_ellipsoid": (
            lambda **arrays: _sinew.nearest_on_ellipsoid((1, 2, 3), **arrays),
            {"points": np.ones((5, 3))},
        ),
    }


ARGUMENTS = [(call, name) for call, (_, arrays) in calls().items() for name in arrays]
FLOATS = [(call, name) for call, name in ARGUMENTS if calls()[call][1][name].dtype.kind == "f" and name != "out"]


def misaligned(array):
    raw = np.zeros(array.nbytes + 1, np.uint8)
    view = raw[1:].view(array.dtype).reshape(array.shape)
    view[...] = array
    return view


def strided(array):
    wide = np.zeros((*array.shape[:-1], 2 * array.shape[-1]), array.dtype)
    wide[..., ::2] = array
    return wide[..., ::2]


SPOILS = {
    "longer": lambda array: np.concatenate([array, array[:1], array[:1]])
    if array.ndim > 1
    else np.append(array, array).astype(array.dtype),
    "one axis more": lambda array: array[None],
    "no axis": lambda array: array.ravel()[0:1].reshape(()),
    "wider last axis": lambda array: np.concatenate([array, array], axis=-1),
    "empty": lambda array: array[:0],
    "other float": lambda array: array.astype(np.float32 if array.dtype == np.float64 else np.float64),
    "half float": lambda array: array.astype(np.float16),
    "long integer": lambda array: array.astype(np.int64),
    "unsigned": lambda array: np.abs(array).astype(np.uint32),
    "complex": lambda array: array.astype(np.complex64),
    "boolean": lambda array: array.astype(bool),
    "object": lambda array: array.astype(object),
    "text": lambda array: array.astype("U8"),
    "record": lambda array: np.zeros(array.shape, [("x", "f4")]),
    "byte-swapped": lambda array: array.astype(array.dtype.newbyteorder()),
    "misaligned": misaligned,
    "strided": strided,
    "reversed": lambda array: array[::-1] if array.size > 1 else array[None],
    "list": lambda array: array.tolist(),
    "tuple": lambda array: tuple(array.ravel().tolist()),
    "none": lambda array: None,
    "text value": lambda array: "array",
    "number": lambda array: 3.0,
    "bytes": lambda array: array.tobytes(),
    "memoryview": lambda array: memoryview(array),
}
# Not errors: lengths that are free, and arrays that may be left out.
FREE = {
    ("Elasticity", "spring_edges", "longer"), ("Elasticity", "spring_edges", "empty"),
    ("Elasticity", "triangles", "longer"), ("Elasticity", "triangles", "empty"),
    *(("Elasticity", name, "none") for name in STRENGTHS), ("Regional", "bones", "none"), ("Regional", "vertices", "none"),
    ("Skin", "edges", "longer"), ("Skin", "edges", "empty"),
    ("nearest_on_ellipsoid", "points", "longer"), ("nearest_on_ellipsoid", "points", "empty"),
}  # fmt: skip


@pytest.mark.parametrize("spoil", SPOILS)
@pytest.mark.parametrize(("call", "name"), ARGUMENTS)
def test_a_bad_array_is_refused_by_name(call, name, spoil):
    function, arrays = calls()[call]
    if (call, name, spoil) in FREE:
        pytest.skip("this is valid")
    good = arrays[name]
    arrays[name] = SPOILS[spoil](good)
    out = arrays.get("out")
    before = out.copy() if isinstance(out, np.ndarray) else None
    with pytest.raises(ValueError, match=r"\w+: |no vertices") as caught:
        function(**arrays)
    if spoil not in (
        "longer",
        "wider last axis",
        "empty",
    ):  # if two arrays do not fit each other, the message may name either
        assert str(caught.value).startswith(f"{name}: ")
    if before is not None:
        np.testing.assert_array_equal(out, before)
    if name == "out":
        assert (good == 7.0).all()


@pytest.mark.parametrize(("call", "name"), [pair for pair in ARGUMENTS if calls()[pair[0]][1][pair[1]].ndim > 1])
def test_fortran_order_is_refused(call, name):
    function, arrays = calls()[call]
    arrays[name] = np.asfortranarray(arrays[name])
    assert not arrays[name].flags.c_contiguous
    with pytest.raises(ValueError, match=f"{name}: .*Fortran order"):
        function(**arrays)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("position", [0, -1])
@pytest.mark.parametrize(("call", "name"), FLOATS)
def test_values_that_are_not_finite_are_refused(call, name, bad, position):
    function, arrays = calls()[call]
    arrays[name] = arrays[name].copy()
    arrays[name].flat[position] = bad
    with pytest.raises(
        ValueError, match=f"{name}: expected numbers from -1e18 to 1e18, got {str(bad).replace('nan', 'NaN')}"
    ):
        function(**arrays)
    assert "out" not in arrays or (arrays["out"] == 7.0).all()


@pytest.mark.parametrize(
    ("call", "name", "value"),
    [
        ("Skeleton", "parents", 2), ("Skeleton", "parents", -2), ("Skeleton", "parents", 2**31 - 1),
        ("Skin", "edges", VERTICES), ("Skin", "edges", -1), ("Skin", "edges", -(2**31)),
        ("Skin", "weight_bones", 2), ("Skin", "weight_bones", -1),
        ("Skin", "weight_offsets", -1), ("Skin", "weight_offsets", 10**6), ("Skin", "weights", -0.1),
        ("ShownTissues", "bones", 2), ("ShownTissues", "bones", -1),
    ],
)  # fmt: skip
@pytest.mark.parametrize("position", [0, -1])
def test_an_index_out_of_range_is_refused(call, name, value, position):
    function, arrays = calls()[call]
    arrays[name] = arrays[name].copy()
    arrays[name].flat[position] = value
    with pytest.raises(ValueError, match=rf"^{name}: entry \d+ is "):
        function(**arrays)


def test_decreasing_offsets_are_refused():
    arrays = dict(LIMB.mesh)
    arrays["weight_offsets"] = arrays["weight_offsets"].copy()
    arrays["weight_offsets"][3] = 0
    with pytest.raises(ValueError, match="^weight_offsets: entry 3 is 0"):
        _sinew.Skin(LIMB.musculature, **arrays)


@pytest.mark.parametrize("call", ["pose", "correct", "deform"])
def test_a_read_only_output_is_refused(call):
    function, arrays = calls()[call]
    arrays["out"].flags.writeable = False
    with pytest.raises(ValueError, match="out: .*writeable"):
        function(**arrays)


@pytest.mark.parametrize("name", ["pose", "tension"])
@pytest.mark.parametrize("call", ["correct", "deform", "pose"])
def test_an_output_that_overlaps_an_input_is_refused(call, name):
    function, arrays = calls()[call]
    good, out = arrays[name], arrays["out"]
    memory = np.zeros(good.size + out.size, np.float32)
    arrays[name] = memory[: good.size].reshape(good.shape)
    arrays[name][...] = good
    for start in (0, good.size - 1):
        arrays["out"] = memory[start : start + out.size].reshape(out.shape)
        before = memory.copy()
        with pytest.raises(ValueError, match=f"^out: .*overlaps {name}"):
            function(**arrays)
        np.testing.assert_array_equal(memory, before)
    arrays["out"] = memory[good.size :].reshape(out.shape)
    function(**arrays)  # disjoint parts of one buffer are allowed


def test_the_same_array_in_and_out_is_refused():
    bones = np.stack([np.eye(4, dtype=np.float32)] * 3)
    skeleton = _sinew.Skeleton(["a", "b", "c"], np.array([-1, 0, 1], np.int32), bones)
    musculature = _sinew.Musculature(
        skeleton, [_sinew.Tissue(name, "SPHERE", 0, 0, (0, 0, 0), (1, 0, 0, 0), (1, 1, 1)) for name in "xyz"]
    )
    with pytest.raises(ValueError, match="out: .*overlaps pose"):
        musculature.pose(bones, np.zeros(3, np.float32), bones)


def test_messages_name_the_array_found_and_the_array_expected():
    with pytest.raises(ValueError) as caught:
        _sinew.Skin(LIMB.musculature, **{**LIMB.mesh, "points": np.zeros((13380, 3))})
    assert str(caught.value) == "points: expected float32 array of shape (V, 3) in C order, got float64 (13380, 3)"
    with pytest.raises(ValueError, match=r"^out: expected .* \(V, 3\) with V = 48 .*, got float32 \(4, 3\)$"):
        SKIN.correct(LIMB.rest, LIMB.relaxed, np.zeros((4, 3), np.float32))


def test_the_rest_points_may_be_read_only():
    arrays = {name: array.copy() for name, array in LIMB.mesh.items()}
    for array in arrays.values():
        array.flags.writeable = False
    assert len(_sinew.Skin(LIMB.musculature, **arrays)) == VERTICES


def test_a_row_major_pose_is_recognized():
    pose = np.ascontiguousarray(np.swapaxes(LIMB.bent(0.5), 1, 2))
    out = np.full((VERTICES, 3), 7.0, np.float32)
    with pytest.raises(_sinew.SinewError, match="row-major"):
        SKIN.correct(pose, LIMB.relaxed, out)
    assert (out == 7.0).all()


def test_an_unknown_rotation_order_is_refused():
    with pytest.raises(ValueError, match="orders: .*XYZ.*'XYX'|orders: .*XYZ.*\"XYX\""):
        shown_tissues(orders=("XYZ", "XYX", "XYZ"), **shown_arguments())
    with pytest.raises(ValueError, match="orders: expected 3, one per tissue, got 1"):
        shown_tissues(orders=("XYZ",), **shown_arguments())


@pytest.mark.parametrize("tension", [-0.01, 1.01])
def test_tension_outside_its_limits_is_refused_by_tissue(tension):
    out = np.full((VERTICES, 3), 7.0, np.float32)
    with pytest.raises(_sinew.SinewError, match="flexor.*tension"):
        SKIN.deform(LIMB.rest, np.array([tension, 0, 0], np.float32), out)
    assert (out == 7.0).all()


def test_no_vertices_and_no_tissues_are_impossible():
    arrays = {**LIMB.mesh, "points": np.zeros((0, 3), np.float32), "weight_offsets": np.zeros(1, np.int32)}
    with pytest.raises(_sinew.SinewError, match="no vertices"):
        _sinew.Skin(LIMB.musculature, **arrays)
    with pytest.raises(_sinew.SinewError, match="no tissues"):
        _sinew.Skin(_sinew.Musculature(LIMB.skeleton, []), **LIMB.mesh)


def test_singular_and_cyclic_rigs_are_impossible():
    flat = column_major(np.stack([np.eye(4), np.diag([1, 1, 0, 1])]))
    with pytest.raises(_sinew.SinewError, match='"b".*inverted'):
        _sinew.Skeleton(["a", "b"], np.array([-1, 0], np.int32), flat)
    with pytest.raises(_sinew.SinewError, match="own ancestor"):
        _sinew.Skeleton(["a", "b"], np.array([1, 0], np.int32), LIMB.rest)
    with pytest.raises(_sinew.SinewError, match="mesh_to_armature"):
        _sinew.Skin(LIMB.musculature, **{**LIMB.mesh, "mesh_to_armature": flat[1].copy()})
