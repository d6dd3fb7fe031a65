# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders of the live skin equal those of the bake: motion blur, view layers, scenes and animations."""

import bpy
import numpy as np
import pytest
from bl_ext.user_default.sinew.bake.cache import playback, point_cache
from bl_ext.user_default.sinew.live import handlers
from conftest import evaluated_points
from test_bake_shape_keys import bake

QUARTERS = range(4, 52)  # quarter frames 1.0 to 12.75


def render(path):
    scene = bpy.context.scene
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(str(path))
    pixels = np.array(image.pixels[:])
    bpy.data.images.remove(image)
    return pixels


def stage(skin, pixels, samples=1):
    """Puts the arm in front of a Cycles camera, with its normals as colors, and with exaggerated swelling."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.device, scene.cycles.samples, scene.cycles.seed = "CPU", samples, 1
    scene.render.resolution_x = scene.render.resolution_y = pixels
    scene.render.image_settings.file_format = "PNG"
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(camera)
    camera.location, camera.data.type, camera.data.ortho_scale = (0.3, 0.1, 2.0), "ORTHO", 0.7
    scene.camera = camera
    scene.world = bpy.data.worlds.new("World")
    material = bpy.data.materials.new("Light")
    if bpy.app.version < (5, 0):
        material.use_nodes = True
    nodes = material.node_tree.nodes
    normal, emission = nodes.new("ShaderNodeNewGeometry"), nodes.new("ShaderNodeEmission")
    material.node_tree.links.new(normal.outputs["Normal"], emission.inputs["Color"])
    material.node_tree.links.new(emission.outputs[0], nodes["Material Output"].inputs["Surface"])
    skin.data.materials.append(material)
    skin.sinew.skin.muscle_influence, skin.sinew.skin.elastic = 3.0, False


@pytest.fixture
def staged(waving, capfd):
    """(mesh, rig): the waving arm in front of a camera."""
    skin, rig = waving
    stage(skin, 64, samples=4)
    yield skin, rig
    assert "Traceback" not in "".join(capfd.readouterr())


@pytest.fixture
def at_each_evaluation():
    """Records the frames of render evaluations, and the correction of the mesh at each."""
    noted = []

    def note(_scene, depsgraph):
        if depsgraph.mode == "RENDER":
            frame = depsgraph.scene.frame_current_final
            noted.append((depsgraph.view_layer.name, frame, correction_of(bpy.data.objects["Arm"])))

    bpy.app.handlers.frame_change_post.append(note)
    yield noted
    bpy.app.handlers.frame_change_post.remove(note)


def correction_of(skin):
    values = np.empty(3 * len(skin.data.vertices), np.float32)
    skin.data.attributes["sinew_correction"].data.foreach_get("vector", values)
    return values


def blur():
    scene = bpy.context.scene
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 0.5
    scene.render.motion_blur_position = "CENTER"


def cache_of_quarters(skin, path):
    """Adds a cache of the points at every quarter of a frame."""
    scene = bpy.context.scene
    timing = point_cache.Timing(QUARTERS, 24.0)
    with open(path, "wb") as file:
        file.write(point_cache.header_of("PC2", timing, len(skin.data.vertices)))
        for quarter in QUARTERS:
            scene.frame_set(quarter // 4, subframe=quarter % 4 / 4)
            point_cache.write_sample(file, "PC2", evaluated_points(skin).astype(np.float32))
    playback.attach(skin, path, "PC2", timing, "Z", len(skin.modifiers), 1.0)
    modifier = skin.modifiers["Sinew Cache"]
    modifier.frame_scale, modifier.frame_start = 4.0, float(QUARTERS[0])


def test_a_render_equals_live_and_baked(waving, tmp_path):
    """Without a viewport, Cycles renders the live skin like the baked keys, and not like the bare armature."""
    skin, _rig = waving
    stage(skin, 96)
    scene = bpy.context.scene
    scene.frame_set(12)
    live = render(tmp_path / "live.png")
    skin.modifiers["Sinew"].show_render = False
    bare = render(tmp_path / "bare.png")
    skin.modifiers["Sinew"].show_render = True
    scene.frame_set(1)
    scene.frame_current = 12  # the renderer has to evaluate the frame
    assert np.array_equal(render(tmp_path / "again.png"), live)
    bake(skin)
    scene.frame_set(12)
    baked = render(tmp_path / "baked.png")
    assert np.abs(live - bare).max() > 0.05
    assert np.abs(baked - live).max() <= 2 / 255


def test_motion_blur_uses_the_points_at_subframes(staged, tmp_path, at_each_evaluation):
    skin, _rig = staged
    scene = bpy.context.scene
    scene.frame_set(8)
    sharp = render(tmp_path / "sharp.png")
    blur()
    at_each_evaluation.clear()
    live = render(tmp_path / "live.png")
    assert {7.75, 8.0, 8.25} <= {frame for _layer, frame, _correction in at_each_evaluation}
    skin.modifiers["Sinew"].show_render = False
    bare = render(tmp_path / "bare.png")
    skin.modifiers["Sinew"].show_render = True
    cache_of_quarters(skin, tmp_path / "quarters.pc2")
    scene.frame_set(8)
    assert np.array_equal(render(tmp_path / "played.png"), live)
    assert np.abs(live - sharp).max() > 0.05 and np.abs(live - bare).max() > 0.05


@pytest.mark.parametrize("blurred", [False, True])
def test_an_animation_with_persistent_data_equals_single_frames(staged, tmp_path, blurred):
    scene = bpy.context.scene
    if blurred:
        blur()
    single = {}
    for frame in (4, 9, 12):
        scene.frame_set(frame)
        single[frame] = render(tmp_path / f"single{frame}.png")
    scene.render.use_persistent_data = True
    scene.frame_start, scene.frame_end, scene.frame_step = 4, 12, 1
    scene.render.filepath = str(tmp_path / "run_")
    bpy.ops.render.render(animation=True)
    assert len(list(tmp_path.glob("run_*.png"))) == 9
    for frame, picture in single.items():
        image = bpy.data.images.load(str(tmp_path / f"run_{frame:04d}.png"))
        assert np.array_equal(np.array(image.pixels[:]), picture)
    assert np.abs(single[4] - single[12]).max() > 0.05


def test_every_view_layer_is_live(staged, tmp_path, at_each_evaluation):
    skin, _rig = staged
    scene = bpy.context.scene
    other = scene.view_layers.new("Other")
    scene.frame_set(11)
    expected = correction_of(skin)
    scene.frame_set(2)
    scene.frame_current = 11
    both = render(tmp_path / "both.png")
    assert {layer for layer, _frame, _correction in at_each_evaluation} == {scene.view_layers[0].name, "Other"}
    for _layer, frame, correction in at_each_evaluation:
        assert frame == 11.0 and np.array_equal(correction, expected)
    scene.view_layers[0].use = False
    assert other.use and np.array_equal(render(tmp_path / "other.png"), both)


def test_a_scene_that_shows_the_same_character_at_another_frame(staged, tmp_path):
    scene = bpy.context.scene
    pictures = {}
    for frame in (3, 12):
        scene.frame_set(frame)
        pictures[frame] = render(tmp_path / f"{frame}.png")
    scene.frame_set(3)
    shown = evaluated_points(bpy.data.objects["Arm"])
    other = scene.copy()
    bpy.context.window.scene = other
    other.frame_set(12)
    assert np.array_equal(render(tmp_path / "of other.png"), pictures[12])
    bpy.context.window.scene = scene
    assert scene.frame_current == 3 and np.array_equal(render(tmp_path / "again.png"), pictures[3])
    bpy.context.view_layer.update()
    assert np.array_equal(evaluated_points(bpy.data.objects["Arm"]), shown)


def test_after_a_render_the_viewport_shows_its_own_frame(staged, tmp_path):
    """After a render with motion blur, the mesh holds the last subframe until the viewport is evaluated."""
    skin, _rig = staged
    scene = bpy.context.scene
    scene.frame_set(8)
    shown = evaluated_points(skin)
    blur()
    render(tmp_path / "blurred.png")
    bpy.context.view_layer.update()
    assert np.array_equal(evaluated_points(skin), shown)


class Over:
    """An object with some attributes replaced, because those of Blender cannot be set."""

    def __init__(self, below, **attributes):
        self.__dict__.update(attributes)
        self._below = below

    def __getattr__(self, name):
        return getattr(self._below, name)


def test_the_viewport_does_not_write_the_mesh_during_a_render(staged, monkeypatch):
    """Without Lock Interface, the viewport answered the render's writes and put its own frame into the mesh."""
    skin, _rig = staged
    scene = bpy.context.scene
    scene.frame_set(11)
    of_render = correction_of(skin)
    jobs, timers = {"RENDER": True}, []
    app = Over(
        bpy.app,
        is_job_running=lambda kind: jobs.get(kind, False),
        timers=Over(
            bpy.app.timers, is_registered=timers.__contains__, register=lambda timer, **_settings: timers.append(timer)
        ),
    )
    monkeypatch.setattr(handlers, "bpy", Over(bpy, app=app))
    scene.frame_set(3)
    scene.frame_set(4)
    assert np.array_equal(correction_of(skin), of_render)
    (after,) = timers
    assert after() > 0.0 and np.array_equal(correction_of(skin), of_render)
    jobs.clear()
    assert after() is None
    own = correction_of(skin)
    monkeypatch.undo()
    scene.frame_set(5)
    scene.frame_set(4)
    assert np.array_equal(correction_of(skin), own) and not np.array_equal(own, of_render)
