# SPDX-License-Identifier: GPL-3.0-or-later
"""Curved muscles in Blender: via points and wraps are Empties that the user moves, renames, duplicates and deletes."""

import math

import bpy
import numpy as np
import pytest
from bl_ext.user_default.sinew.scene import tissue_empty
from conftest import add_muscle, bend, bind, delete_in_viewport, evaluated_points, rest_points, save_and_take, select
from mathutils import Matrix, Quaternion, Vector


def triceps(rig):
    """A muscle behind the elbow. A positive rotation of the lower bone about its z stretches it."""
    return add_muscle(rig, around=-math.pi / 2, offset=0.12, fit_skin=False)


def elbow(rig):
    return add_muscle(rig, kind="SPHERE", origin_bone="lower", insertion_bone="", name="Elbow", fit_skin=False)


def wrap(muscle, *spheres, **options):
    select(muscle, *spheres)
    return bpy.ops.sinew.wrap(**options)


def add_via(muscle, **options):
    before = set(bpy.data.objects)
    select(muscle)
    bpy.ops.sinew.add_via_point(**options)
    return (set(bpy.data.objects) - before).pop()


@pytest.fixture
def wrapped(arm):
    """(mesh, rig, muscle, sphere), with a sphere so small that the straight muscle does not touch it."""
    skin, rig = arm
    muscle, sphere = triceps(rig), elbow(rig)
    sphere.scale = (0.02, 0.02, 0.02)
    assert wrap(muscle, sphere) == {"FINISHED"}
    bpy.context.view_layer.update()
    return skin, rig, muscle, sphere


def state_of(rig):
    from bl_ext.user_default.sinew.live import session
    from bl_ext.user_default.sinew.scene import characters

    return session.rig_state(rig, characters.tissues_of(rig), bpy.context.evaluated_depsgraph_get())


def shape_of(muscle):
    from bl_ext.user_default.sinew.scene import tissue_empty

    return tissue_empty.read(muscle, muscle.parent)


def path_of(rig, muscle):
    state = state_of(rig)
    points, offsets = state.musculature.path_points(state.pose)
    place = [found.name for found in _solved(rig, state)].index(muscle.name)
    return points[offsets[place] : offsets[place + 1]].astype(np.float64)


def _solved(rig, state):
    from bl_ext.user_default.sinew.scene import characters

    tissues = characters.tissues_of(rig)
    return [tissues[place] for place in state.solved]


def length(path):
    return np.linalg.norm(np.diff(path, axis=0), axis=1).sum()


def stretching(rig):
    """The sign of the angle that stretches the triceps."""
    muscle = next(found for found in bpy.data.objects if found.name.startswith("Muscle"))
    lengths = []
    for angle in (0.3, -0.3):
        bend(rig, angle)
        lengths.append(length(path_of(rig, muscle)))
    bend(rig, 0.0)
    return 1.0 if lengths[0] > lengths[1] else -1.0


def test_a_muscle_wraps_around_its_sphere(wrapped):
    _skin, rig, muscle, _sphere = wrapped
    sign, last = stretching(rig), None
    volumes = set()
    for degrees in range(0, 151, 3):
        bend(rig, sign * math.radians(degrees))
        path = path_of(rig, muscle)
        centre = np.array(rig.pose.bones["lower"].head)
        assert np.linalg.norm(path - centre, axis=1).min() > 0.02
        state = state_of(rig)
        posed = state.musculature.pose(state.pose, state.tension, state.posed.copy())
        volumes.add(float(posed.volume.sum()))
        shown = np.array(muscle.matrix_world)
        if last is not None:
            assert abs(shown - last).max() < 0.02
        last = shown
    assert length(path) > 0.05 and max(volumes) / min(volumes) - 1 < 1e-6
    assert len(path) > 10  # it wraps around the sphere now


def test_the_rest_pose_shows_the_empty_at_its_own_location(wrapped):
    _skin, _rig, muscle, _sphere = wrapped
    add_via(muscle).location.y += 0.03
    bpy.context.view_layer.update()
    assert Vector(muscle.delta_location).length < 1e-6
    assert (Vector(muscle.delta_scale) - Vector((1, 1, 1))).length < 1e-5


def test_a_via_point_is_added_on_the_path_and_dragged(arm):
    skin, rig = arm
    muscle = triceps(rig)
    bind(skin)
    before = shape_of(muscle)
    straight = (before.insertion - before.origin).length
    via = add_via(muscle, share=0.25)
    assert via.sinew.tissue.kind == "VIA" and via.sinew.tissue.muscle == muscle and via.parent_bone == "upper"
    assert via.empty_display_type == "PLAIN_AXES" and via.parent == rig
    ((bone, point),) = shape_of(muscle).via_points
    assert bone == "upper" and (point - before.origin.lerp(before.insertion, 0.25)).length < 1e-6
    assert length(path_of(rig, muscle)) == pytest.approx(straight, abs=1e-6)
    via.location += Vector((0.0, -0.05, 0.0))
    bpy.context.view_layer.update()
    path = path_of(rig, muscle)
    assert length(path) > straight + 0.005
    ((_bone, moved),) = shape_of(muscle).via_points
    assert np.linalg.norm(path - np.array(moved), axis=1).min() < 1e-6
    assert np.abs(evaluated_points(skin) - rest_points(skin)).max() <= 1e-6
    bend(rig, 1.0)
    assert np.abs(evaluated_points(skin) - rest_points(skin)).max() > 1e-2


def test_via_points_keep_their_order_along_the_muscle(arm):
    _skin, rig = arm
    muscle = triceps(rig)
    late, early = add_via(muscle, share=0.98), add_via(muscle, share=0.1)
    middle = add_via(muscle, share=0.5, bone="lower")
    vias = sorted((late, middle, early), key=lambda via: via.sinew.tissue.order)
    assert vias == [early, middle, late]
    assert [bone for bone, _point in shape_of(muscle).via_points] == ["upper", "lower", "lower"]
    select(muscle, middle)
    bpy.ops.sinew.remove_via_points()
    assert len(shape_of(muscle).via_points) == 2
    select(muscle)
    bpy.ops.sinew.remove_via_points()
    assert shape_of(muscle).via_points == ()
    assert not any(found.sinew.tissue.kind == "VIA" for found in bpy.data.objects)


def test_create_read_and_write_keep_a_path(arm):
    from bl_ext.user_default.sinew.muscles import edit
    from bl_ext.user_default.sinew.scene import tissue_empty

    _skin, rig = arm
    shape, ball = shape_of(triceps(rig)), shape_of(elbow(rig))
    points = (("upper", Vector((0.2, -0.1, 0.02))), ("lower", Vector((0.35, -0.11, 0.0))))
    curved = tissue_empty.TissueShape(**{**vars(shape), "name": "Curved", "via_points": points, "wraps": ("Ball",)})
    ball = tissue_empty.TissueShape(**{**vars(ball), "name": "Ball"})
    muscle, sphere = edit.add(rig, [curved, ball])
    found = shape_of(muscle)
    assert found.wraps == ("Ball",) and [bone for bone, _ in found.via_points] == ["upper", "lower"]
    assert max((a - b).length for (_, a), (_, b) in zip(found.via_points, points)) < 1e-6
    sphere.name = "Kneecap"
    assert shape_of(muscle).wraps == ("Kneecap",)
    shorter = tissue_empty.TissueShape(**{**vars(shape_of(muscle)), "via_points": points[1:], "wraps": ()})
    tissue_empty.write(muscle, shorter)
    found = shape_of(muscle)
    assert found.wraps == () and len(found.via_points) == 1
    assert found.via_points[0][0] == "lower" and (found.via_points[0][1] - points[1][1]).length < 1e-6


def test_a_wrap_around_nothing_is_refused_and_changes_nothing(arm):
    from bl_ext.user_default.sinew import errors
    from bl_ext.user_default.sinew.muscles import edit
    from bl_ext.user_default.sinew.scene import tissue_empty

    _skin, rig = arm
    muscle = triceps(rig)
    shape = tissue_empty.TissueShape(**{**vars(shape_of(muscle)), "wraps": ("Nothing",)})
    with pytest.raises(errors.SinewError, match="Nothing"):
        edit.add(rig, [shape])
    assert muscle.name in bpy.data.objects
    select(muscle)
    with pytest.raises(RuntimeError, match="Select a sphere"):
        bpy.ops.sinew.wrap()
    select(rig)
    assert not bpy.ops.sinew.wrap.poll() and not bpy.ops.sinew.add_via_point.poll()


def test_unwrap(wrapped):
    _skin, _rig, muscle, sphere = wrapped
    assert shape_of(muscle).wraps == ("Elbow",)
    wrap(muscle, sphere)
    assert len(muscle.sinew.tissue.wraps) == 1
    wrap(muscle, unwrap=True)
    assert shape_of(muscle).wraps == ()


def test_a_replaced_sphere_is_still_wrapped(wrapped):
    from bl_ext.user_default.sinew.muscles import edit

    _skin, rig, muscle, sphere = wrapped
    edit.add(rig, [shape_of(sphere)])
    assert shape_of(muscle).wraps == ("Elbow",)


def test_objects_deleted_in_the_viewport_are_gone(wrapped):
    from bl_ext.user_default.sinew.scene import characters

    _skin, rig, muscle, sphere = wrapped
    via = add_via(muscle)
    select(sphere)
    bpy.ops.object.delete()
    bpy.context.view_layer.update()
    assert shape_of(muscle).wraps == ()
    assert len(state_of(rig).musculature) == 1
    select(muscle)
    bpy.ops.object.delete()
    bpy.context.view_layer.update()
    assert characters.character_of(rig) is None or not characters.character_of(rig).tissues
    assert via.name in bpy.data.objects
    select(rig)
    bpy.ops.sinew.remove()
    assert not any(found.sinew.tissue.kind == "VIA" for found in bpy.data.objects)


def test_remove_leaves_nothing(wrapped):
    skin, rig, muscle, _sphere = wrapped
    add_via(muscle)
    bind(skin)
    select(rig)
    bpy.ops.sinew.remove()
    assert not any(found.type == "EMPTY" for found in bpy.data.objects)


def test_duplicate(wrapped):
    skin, rig, muscle, sphere = wrapped
    via = add_via(muscle, share=0.3)
    via.location.y -= 0.02
    bind(skin)
    bend(rig, 0.8)
    select(skin, rig, muscle, sphere, via)
    bpy.ops.object.duplicate()
    twins = bpy.context.selected_objects
    twin_via = next(found for found in twins if found.type == "EMPTY" and found.sinew.tissue.kind == "VIA")
    twin = twin_via.sinew.tissue.muscle
    assert twin in twins and twin.sinew.tissue.wraps[0].sphere in twins
    twin_skin = next(found for found in twins if found.type == "MESH")
    bpy.context.view_layer.update()
    assert np.abs(evaluated_points(twin_skin) - evaluated_points(skin)).max() <= 1e-6


def test_append(wrapped, tmp_path):
    skin, rig, muscle, _sphere = wrapped
    add_via(muscle, share=0.3).location.y -= 0.02
    bind(skin)
    bend(rig, 0.8)
    before = evaluated_points(skin)
    path = tmp_path / "arm.blend"
    save_and_take(path)
    assert np.array_equal(evaluated_points(bpy.data.objects["Arm"]), before)
    bpy.ops.wm.open_mainfile(filepath=str(path))
    assert np.array_equal(evaluated_points(bpy.data.objects["Arm"]), before)


def test_undo_of_a_via_point(wrapped):
    skin, rig, muscle, _sphere = wrapped
    bind(skin)
    bend(rig, 0.8)
    bpy.ops.ed.undo_push(message="before")
    before = evaluated_points(skin)
    via = add_via(muscle, share=0.4)
    via.location.y -= 0.05
    bpy.context.view_layer.update()
    bpy.ops.ed.undo_push(message="via")
    after = evaluated_points(skin)
    assert not np.array_equal(after, before)
    bpy.ops.ed.undo()
    assert np.array_equal(evaluated_points(bpy.data.objects["Arm"]), before)
    bpy.ops.ed.redo()
    assert np.array_equal(evaluated_points(bpy.data.objects["Arm"]), after)


def test_a_via_point_without_its_bone_is_named(wrapped):
    _skin, rig, muscle, _sphere = wrapped
    via = add_via(muscle)
    via.parent_type = "OBJECT"
    bpy.context.view_layer.update()
    assert via.name in state_of(rig).problems[muscle.name]


JOINTS = (
    ("forearm", "lowerarm01.L", 1.0, 104, 0.02, ("Triceps brachii, long head", "Triceps brachii, lateral head")),
    ("shin", "lowerleg01.L", -1.0, 140, 0.035, ("Rectus femoris", "Vastus lateralis", "Vastus medialis")),
)


@pytest.mark.one_blender
@pytest.mark.parametrize(("segment", "bone", "sign", "limit", "radius_m", "muscles"), JOINTS, ids=("elbow", "knee"))
def test_muscles_of_the_real_body_over_a_whole_joint(real_body, segment, bone, sign, limit, radius_m, muscles):
    """The elbow is at 46 degrees in the rest pose, so 104 more are 150."""
    from bl_ext.user_default.sinew.muscles.placing.recognise import segments
    from bl_ext.user_default.sinew.scene import characters

    _skin, rig = real_body
    select(rig)
    bpy.ops.sinew.add_preset(name="limbs")
    select(rig)
    bpy.ops.sinew.add_tissue(kind="SPHERE", origin_bone=bone, name="Ball", fit_skin=False)
    ball = bpy.data.objects["Ball"]
    ball.scale = (radius_m,) * 3
    chosen = [bpy.data.objects[f"{name}.L"] for name in muscles]
    for muscle in chosen:
        wrap(muscle, ball)
    own = segments.recognise(rig).segment(segment, "L")
    rest = rig.data.bones[bone].matrix_local
    step_deg, before, volumes = 1, None, []
    for degrees in range(0, limit + 1, step_deg):
        turn = Quaternion(own.axis.cross(own.front), sign * math.radians(degrees)).to_matrix().to_4x4()
        rig.pose.bones[bone].matrix = (
            Matrix.Translation(rest.translation) @ turn @ Matrix.Translation(-rest.translation) @ rest
        )
        bpy.context.view_layer.update()
        state = state_of(rig)
        places = [characters.tissues_of(rig).index(muscle) for muscle in chosen]
        volumes.append(state.musculature.pose(state.pose, state.tension, state.posed.copy()).volume[places])
        ellipsoids = np.empty((state.musculature.ellipsoid_count, 4, 4), np.float32)
        state.musculature.pose_ellipsoids(state.pose, state.tension, ellipsoids)
        links = ellipsoids[np.isin(state.musculature.ellipsoid_tissue, places)]
        if before is not None:
            # largest motion per degree: the length of the limb, 0.5 m, times the angle
            assert np.abs(links - before).max() < 2.0 * 0.5 * math.radians(step_deg), degrees
        before = links
        for muscle in chosen:
            path = path_of(rig, muscle)
            clear_m = min(radius_m, *(np.linalg.norm(end - np.array(rest.translation)) for end in (path[0], path[-1])))
            assert np.linalg.norm(path - np.array(rest.translation), axis=1).min() > clear_m - 1e-6, (muscle.name, degrees)
    assert np.ptp(np.array(volumes) / volumes[0]) < 1e-6


@pytest.mark.parametrize("operator", ["add_via_point", "remove_via_points", "wrap"])
def test_a_via_point_of_a_deleted_muscle_is_refused(human, operator):
    via = tissue_empty.vias_of(bpy.data.objects["Sartorius.L"])[0]
    delete_in_viewport("Sartorius.L")
    select(via)
    with pytest.raises(RuntimeError, match="its muscle Sartorius.L was deleted"):
        getattr(bpy.ops.sinew, operator)()
