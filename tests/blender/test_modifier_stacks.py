# SPDX-License-Identifier: GPL-3.0-or-later
"""Stacks of modifiers as people have them: bodies in shape keys, Mask, modifiers before and after the Armature modifier."""

import bpy
import numpy as np
import pytest
from bl_ext.user_default.sinew.live import session
from bl_ext.user_default.sinew.muscles.placing.fit.skin_surface import SkinSurface
from conftest import FLEXOR, add_muscle, armature_alone, bend, bind, evaluated_points, make_arm, rest_points, select
from mathutils import Vector

ANGLE = 1.2


def in_shape_key(skin, width=1.3):
    """Makes the arm thicker in the value of a shape key. Returns the key."""
    skin.shape_key_add(name="Basis")
    key = skin.shape_key_add(name="Thick")
    points = rest_points(skin) * (1.0, width, width)
    key.points.foreach_set("co", points.astype(np.float32).reshape(-1))
    key.value = 1.0
    bpy.context.view_layer.update()
    return key


def baked_shape(skin, width=1.3):
    """Makes the arm as thick in its mesh itself."""
    points = rest_points(skin) * (1.0, width, width)
    skin.data.vertices.foreach_set("co", points.astype(np.float32).reshape(-1))
    skin.data.update()


def bent_skin(shape):
    skin, rig = make_arm()
    shape(skin)
    muscle = add_muscle(rig, around=FLEXOR)
    scale = tuple(muscle.scale)
    bind(skin)
    bend(rig, ANGLE)
    return evaluated_points(skin), scale, skin, rig


# Shape keys


def test_a_body_in_shape_key_values_is_fitted_and_bound_as_if_the_keys_were_applied():
    plain, plain_scale, skin, rig = bent_skin(baked_shape)
    for found in list(bpy.data.objects):
        bpy.data.objects.remove(found)
    bpy.context.view_layer.update()
    points, scale, skin, rig = bent_skin(in_shape_key)
    assert scale == pytest.approx(plain_scale, rel=1e-5)
    assert np.abs(points - plain).max() < 2e-6
    assert np.abs(points - armature_alone(skin)).max() > 1e-3


@pytest.mark.parametrize("plays", ["keyframes", "driver on a bone", "muted", "raised after the bind"])
def test_keys_that_play_do_not_form_the_rest_body(plays):
    skin, rig = make_arm()
    add_muscle(rig, around=FLEXOR)
    key = in_shape_key(skin)
    if plays == "keyframes":
        key.keyframe_insert("value", frame=1)
    elif plays == "driver on a bone":
        driver = key.driver_add("value").driver
        variable = driver.variables.new()
        variable.type = "TRANSFORMS"
        variable.targets[0].id, variable.targets[0].bone_target = rig, "lower"
        driver.type = "SCRIPTED"
        driver.expression = "1.0 + 0.0 * var"
    elif plays == "muted":
        key.mute = True
    else:
        key.value = 0.0
    bind(skin)
    key.value = 1.0
    bpy.context.view_layer.update()
    state = session.cached_skin(skin)
    assert np.allclose(np.abs(state.points[:, 1:]).max(), 0.05)


def test_a_driven_slider_of_the_body_is_followed_without_an_edit_of_the_mesh():
    skin, rig = make_arm()
    rig["thickness"] = 1.0
    key = in_shape_key(skin)
    driver = key.driver_add("value").driver
    variable = driver.variables.new()
    variable.targets[0].id, variable.targets[0].data_path = rig, '["thickness"]'
    driver.type = "AVERAGE"
    rig.update_tag()
    bpy.context.view_layer.update()
    add_muscle(rig, around=FLEXOR)
    bind(skin)
    assert session.cached_skin(skin).points[:, 1].max() == pytest.approx(0.065, abs=1e-5)
    rig["thickness"] = 0.5
    rig.update_tag()
    bpy.context.view_layer.update()
    bpy.context.scene.frame_set(2)
    assert session.cached_skin(skin).points[:, 1].max() == pytest.approx(0.0575, abs=1e-5)


# Mask


def with_helpers(skin):
    """Adds a tube around the arm that a Mask modifier hides, as MPFB's helpers are."""
    select(skin)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.duplicate()
    bpy.ops.transform.resize(value=(1.0, 0.5, 0.5), center_override=(0.0, 0.0, 0.0))
    bpy.ops.object.mode_set(mode="OBJECT")
    group = skin.vertex_groups.new(name="body")
    group.add(list(range(480)), 1.0, "REPLACE")
    mask = skin.modifiers.new("Hide helpers", "MASK")
    mask.vertex_group = "body"
    bpy.context.view_layer.update()
    assert len(skin.data.vertices) == 960


def test_helper_vertices_that_a_mask_hides_take_no_part():
    plain, plain_scale, skin, rig = bent_skin(lambda skin: None)
    for found in list(bpy.data.objects):
        bpy.data.objects.remove(found)
    bpy.context.view_layer.update()
    points, scale, skin, rig = bent_skin(with_helpers)
    assert scale == pytest.approx(plain_scale, rel=1e-5)
    assert len(points) == 480 and np.abs(points - plain).max() < 2e-6
    surface = SkinSurface.of(skin, rig)
    assert surface.distance_along(Vector((0.31, 0, 0)), Vector((0, 0, 1))) > 0.04


def test_painting_the_group_of_a_mask_makes_the_bind_again():
    _points, _scale, skin, _rig = bent_skin(with_helpers)
    assert session.cached_skin(skin).shown.sum() == 480
    skin.vertex_groups["body"].add(list(range(480, 960)), 1.0, "REPLACE")
    bpy.context.view_layer.update()
    assert session.cached_skin(skin).shown is None


# Modifiers before and after


def before_armature(skin, kind):
    modifier = skin.modifiers.new(kind.title(), kind)
    skin.modifiers.move(skin.modifiers.find(modifier.name), 0)
    return modifier


@pytest.mark.parametrize("kind", ["MIRROR", "ARRAY", "SCREW", "DECIMATE", "REMESH", "BOOLEAN"])
def test_modifiers_with_which_no_correction_is_right_are_refused_before_anything_changes(arm, kind):
    skin, rig = arm
    add_muscle(rig, around=FLEXOR)
    before_armature(skin, kind)
    stack = [modifier.name for modifier in skin.modifiers]
    select(skin)
    with pytest.raises(RuntimeError, match="acts before the Armature modifier, and .* Apply it"):
        bpy.ops.sinew.bind()
    assert [modifier.name for modifier in skin.modifiers] == stack
    assert "sinew_correction" not in skin.data.attributes and not skin.sinew.skin.bound


@pytest.mark.parametrize("kind", ["MIRROR", "ARRAY", "DECIMATE", "SUBSURF", "SOLIDIFY", "BEVEL", "TRIANGULATE", "SMOOTH"])
def test_modifiers_after_the_armature_act_on_the_corrected_skin(arm, kind):
    """They give what the same modifier gives on a mesh that has the shape of the corrected skin."""
    skin, rig = arm
    add_muscle(rig, around=FLEXOR)
    bind(skin)
    bend(rig, ANGLE)
    plain = evaluated_points(skin)
    shaped = bpy.data.objects.new("Shaped", skin.data.copy())
    bpy.context.scene.collection.objects.link(shaped)
    shaped.data.vertices.foreach_set("co", plain.astype(np.float32).reshape(-1))
    for owner in (skin, shaped):
        owner.modifiers.new(kind.title(), kind)
    bpy.context.view_layer.update()
    assert session.reason(skin) == ""
    found, expected = evaluated_points(skin), evaluated_points(shaped)
    assert found.shape == expected.shape and np.abs(found - expected).max() < 1e-5


def test_subdivision_before_the_armature_shows_the_correction(arm):
    """The correction of the new vertices is that of their neighbours; the vertices of the mesh are within 1 mm of it."""
    skin, rig = arm
    add_muscle(rig, around=FLEXOR)
    bind(skin)
    bend(rig, ANGLE)
    plain, alone = evaluated_points(skin), armature_alone(skin)
    subdivision = before_armature(skin, "SUBSURF")
    subdivision.subdivision_type = "SIMPLE"
    bpy.context.view_layer.update()
    assert session.reason(skin) == ""
    assert np.abs(evaluated_points(skin)[:480] - plain).max() < 1e-6
    assert np.abs(plain - alone).max() > 1e-3


def test_multires_stays_first_and_its_skin_is_corrected(arm):
    skin, rig = arm
    plain = expected_bend(skin, rig)
    modifier = before_armature(skin, "MULTIRES")
    select(skin)
    bpy.ops.object.multires_subdivide(modifier=modifier.name, mode="SIMPLE")
    bpy.ops.sinew.bind()
    assert [found.type for found in skin.modifiers] == ["MULTIRES", "NODES", "ARMATURE"]
    bpy.context.view_layer.update()
    points = evaluated_points(skin)
    assert len(points) > 480
    assert np.abs(points[:480] - plain).max() < 1e-4


def expected_bend(skin, rig):
    """The bent skin, after which it is unbound again."""
    add_muscle(rig, around=FLEXOR)
    bind(skin)
    bend(rig, ANGLE)
    points = evaluated_points(skin)
    select(skin)
    bpy.ops.sinew.unbind()
    return points


def test_multires_after_the_armature_is_refused_in_words(arm):
    skin, rig = arm
    add_muscle(rig, around=FLEXOR)
    skin.modifiers.new("Multires", "MULTIRES")
    select(skin)
    with pytest.raises(RuntimeError, match="Move 'Multires' above the Armature modifier"):
        bpy.ops.sinew.bind()
    assert [found.type for found in skin.modifiers] == ["ARMATURE", "MULTIRES"]
    assert "sinew_correction" not in skin.data.attributes


def nodes(skin, kind):
    """A Geometry Nodes modifier before the Armature modifier with one node of this kind."""
    group = bpy.data.node_groups.new("Group", "GeometryNodeTree")
    for way in ("INPUT", "OUTPUT"):
        group.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
    first, node, last = (group.nodes.new(name) for name in ("NodeGroupInput", kind, "NodeGroupOutput"))
    socket = next(socket for socket in node.inputs if socket.type == "GEOMETRY")
    group.links.new(first.outputs[0], socket)
    group.links.new(next(socket for socket in node.outputs if socket.type == "GEOMETRY"), last.inputs[0])
    modifier = before_armature(skin, "NODES")
    modifier.node_group = group
    return modifier


def test_geometry_nodes_that_keep_the_vertices_are_right(arm):
    skin, rig = arm
    plain = expected_bend(skin, rig)
    nodes(skin, "GeometryNodeSetShadeSmooth")
    select(skin)
    bpy.ops.sinew.bind()
    bpy.context.view_layer.update()
    assert np.abs(evaluated_points(skin) - plain).max() < 1e-6


def test_geometry_nodes_that_make_vertices_are_refused_by_the_name_of_the_node(arm):
    skin, rig = arm
    add_muscle(rig, around=FLEXOR)
    nodes(skin, "GeometryNodeSubdivideMesh")
    select(skin)
    with pytest.raises(RuntimeError, match="its node 'Subdivide Mesh' can make other vertices"):
        bpy.ops.sinew.bind()


# Order


def test_the_order_of_modifiers_is_watched(muscled):
    skin, rig = muscled
    bend(rig, ANGLE)
    plain, alone = evaluated_points(skin), armature_alone(skin)
    skin.modifiers.move(0, 1)
    bpy.context.view_layer.update()
    assert "below 'Armature'" in session.reason(skin)
    assert np.abs(evaluated_points(skin) - alone).max() < 1e-6
    skin.modifiers.move(1, 0)
    bpy.context.view_layer.update()
    assert session.reason(skin) == ""
    assert np.abs(evaluated_points(skin) - plain).max() < 1e-6


def test_a_mirror_added_after_the_bind_is_reported_and_gets_no_correction(muscled):
    skin, rig = muscled
    bend(rig, ANGLE)
    plain, alone = evaluated_points(skin), armature_alone(skin)
    mirror = before_armature(skin, "MIRROR")
    mirror.use_mirror_merge = False
    bpy.context.view_layer.update()
    assert "'Mirror' acts before the Armature modifier" in session.reason(skin)
    assert np.abs(evaluated_points(skin)[:480] - alone).max() < 1e-6
    mirror.show_viewport = mirror.show_render = False
    bpy.context.view_layer.update()
    assert np.abs(evaluated_points(skin) - plain).max() < 1e-6


# Two Armature modifiers


def pair(skin, rig, inverted, first_preserves=False, grouped=True):
    """The stack of MPFB and CharMorph: linear, and Preserve Volume by the weight of a vertex group."""
    group = skin.vertex_groups.new(name="preserve volume")
    for index, point in enumerate(rest_points(skin)):
        group.add([index], float(np.clip(0.5 + 8.0 * point[1], 0.0, 1.0)), "REPLACE")
    skin.modifiers["Armature"].use_deform_preserve_volume = first_preserves
    second = skin.modifiers.new("Preserve", "ARMATURE")
    second.object = rig
    second.use_multi_modifier = True
    second.use_deform_preserve_volume = not first_preserves
    second.invert_vertex_group = inverted
    second.vertex_group = "preserve volume" if grouped else ""
    return second


@pytest.mark.parametrize("inverted", [False, True])
@pytest.mark.parametrize("first_preserves", [False, True])
@pytest.mark.parametrize("grouped", [False, True])
def test_a_pair_of_armature_modifiers_is_followed_exactly(arm, inverted, first_preserves, grouped):
    """Without influence of muscles nothing is corrected: the core computes what Blender's two modifiers do."""
    skin, rig = arm
    add_muscle(rig, around=FLEXOR)
    pair(skin, rig, inverted, first_preserves, grouped)
    skin.sinew.skin.elastic, skin.sinew.skin.muscle_influence = False, 0.0
    bind(skin)
    bend(rig, 0.9, axis=1)
    bend(rig, ANGLE)
    alone = armature_alone(skin)
    state = session.cached_skin(skin)
    posed = np.empty_like(state.points)
    rig_state = session.cached_rig(rig)
    state.skin.deform(rig_state.pose, rig_state.tension, posed)
    assert np.abs(posed - alone).max() < 2e-6
    assert np.abs(evaluated_points(skin) - alone).max() < 2e-6


def test_a_pair_of_armature_modifiers_shows_the_muscles(arm):
    skin, rig = arm
    add_muscle(rig, around=FLEXOR)
    pair(skin, rig, inverted=True)
    bind(skin)
    bend(rig, ANGLE)
    state, rig_state = session.cached_skin(skin), session.cached_rig(rig)
    posed = np.empty_like(state.points)
    state.skin.deform(rig_state.pose, rig_state.tension, posed)
    assert np.abs(evaluated_points(skin) - posed).max() < 1e-5
    assert np.abs(posed - armature_alone(skin)).max() > 1e-3
    skin.vertex_groups["preserve volume"].add(list(range(480)), 1.0, "REPLACE")
    bpy.context.view_layer.update()
    assert np.all(session.cached_skin(skin).weights.preserved_fractions == 0.0)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda skin, second: setattr(second, "use_multi_modifier", False), "turn its Multi Modifier on"),
        (lambda skin, second: setattr(skin.modifiers[0], "vertex_group", "upper"), "Clear the group"),
        (
            lambda skin, second: skin.modifiers.move(0, 1),
            "Multi Modifier on, but it is the first|turn its Multi",
        ),
        (lambda skin, second: setattr(second, "use_vertex_groups", False), "Bind To Vertex Groups"),
        (lambda skin, second: setattr(second, "use_bone_envelopes", True), "Bone Envelopes"),
    ],
)
def test_other_pairs_are_refused_in_words(arm, change, message):
    skin, rig = arm
    add_muscle(rig, around=FLEXOR)
    change(skin, pair(skin, rig, inverted=True))
    select(skin)
    with pytest.raises(RuntimeError, match=message):
        bpy.ops.sinew.bind()
    assert not skin.sinew.skin.bound and "sinew_correction" not in skin.data.attributes


def test_armature_modifiers_of_two_armatures_are_refused_in_words(arm):
    skin, rig = arm
    add_muscle(rig, around=FLEXOR)
    _other, second_rig = make_arm("Other")
    pair(skin, rig, inverted=True).object = second_rig
    bpy.context.view_layer.update()
    select(skin)
    with pytest.raises(RuntimeError, match="follows several armatures"):
        bpy.ops.sinew.bind()
