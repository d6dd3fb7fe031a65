# SPDX-License-Identifier: GPL-3.0-or-later
"""The contents of an exported .glb: normals of morph targets, sparse data, materials that multiply nothing."""

import json
import os
import struct
import subprocess

import bpy
import numpy as np
import pytest
from conftest import FLEXOR, add_muscle, bind, make_arm, select
from test_muscle_bones import bake_bones

VALIDATOR = os.environ.get("SINEW_GLTF_VALIDATOR", "")
VALIDATE = """
const file = new Uint8Array(require("fs").readFileSync(process.argv[1]));
require("gltf-validator").validateBytes(file).then((report) => console.log(JSON.stringify(report.issues)));
"""
COMPONENTS = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


class Glb:
    """A .glb file: its JSON and its accessors as arrays."""

    def __init__(self, path):
        data = path.read_bytes()
        length = struct.unpack_from("<I", data, 12)[0]
        self.json, self._binary = json.loads(data[20 : 20 + length]), data[28 + length :]

    def array(self, index):
        """(count, width) float64."""
        accessor = self.json["accessors"][index]
        width = WIDTHS[accessor["type"]]
        values = np.zeros((accessor["count"], width))
        if "bufferView" in accessor:
            offset = accessor.get("byteOffset", 0)
            values[:] = self._read(accessor["bufferView"], offset, accessor["componentType"], values.shape)
        if "sparse" in accessor:
            sparse = accessor["sparse"]
            rows, changed = sparse["indices"], sparse["values"]
            at = self._read(rows["bufferView"], rows.get("byteOffset", 0), rows["componentType"], (sparse["count"], 1))
            shape = (sparse["count"], width)
            values[at[:, 0].astype(int)] = self._read(
                changed["bufferView"], changed.get("byteOffset", 0), accessor["componentType"], shape
            )
        return values

    def _read(self, view, offset, component, shape):
        start = self.json["bufferViews"][view].get("byteOffset", 0) + offset
        count = shape[0] * shape[1]
        return np.frombuffer(self._binary, COMPONENTS[component], count, start).reshape(shape).astype(np.float64)

    def primitives(self):
        return self.json["meshes"][0]["primitives"]

    def targets(self):
        """The accessors of all morph targets."""
        return {index for primitive in self.primitives() for target in primitive["targets"] for index in target.values()}


def baked(materials=1, **settings):
    """(mesh, rig): an arm with smooth faces and correctives of its elbow."""
    skin, rig = make_arm(rings=settings.pop("rings", 24), around=settings.pop("around", 20))
    skin.data.polygons.foreach_set("use_smooth", np.ones(len(skin.data.polygons), bool))
    for number in range(materials):
        skin.data.materials.append(bpy.data.materials.new(f"material {number}"))
    slots = np.arange(len(skin.data.polygons)) * materials // len(skin.data.polygons)
    skin.data.polygons.foreach_set("material_index", slots.astype(np.int32))
    add_muscle(rig, around=FLEXOR)
    bind(skin)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, 4
    bpy.ops.sinew.bake_correctives(**{"joints": "lower", "tolerance": 1.0} | settings)
    bake_bones(rig, frame_end=4)
    return skin, rig


def export(rig, path, file_format="GLTF"):
    select(rig)
    assert bpy.ops.sinew.export(filepath=str(path), format=file_format) == {"FINISHED"}
    return path


def vertex_normals(points, triangles):
    """(vertices, 3): the normals of smooth faces, weighted with their angles, as Blender's are."""
    corners = points[triangles]
    normals = np.zeros_like(points)
    face = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    face /= np.linalg.norm(face, axis=1)[:, None]
    for corner in range(3):
        a, b = (corners[:, (corner + step) % 3] - corners[:, corner] for step in (1, 2))
        angle = np.arccos((a * b).sum(axis=1) / np.linalg.norm(a, axis=1) / np.linalg.norm(b, axis=1))
        np.add.at(normals, triangles[:, corner], angle[:, None] * face)
    return normals / np.linalg.norm(normals, axis=1)[:, None]


def test_morph_normals_are_those_of_the_morphed_surface(tmp_path):
    _skin, rig = baked()
    glb = Glb(export(rig, tmp_path / "arm.glb"))
    (primitive,) = glb.primitives()
    attributes = primitive["attributes"]
    points, normals = glb.array(attributes["POSITION"]), glb.array(attributes["NORMAL"])
    triangles = glb.array(primitive["indices"]).astype(int).reshape(-1, 3)
    # Blender's quads weight their corners differently than the file's triangles; that difference is the same in a morph
    bias = normals - vertex_normals(points, triangles)
    assert len(primitive["targets"]) > 5
    for target in primitive["targets"]:
        morphed = normals + glb.array(target["NORMAL"])
        expected = vertex_normals(points + glb.array(target["POSITION"]), triangles) + bias
        assert np.abs(np.linalg.norm(morphed, axis=1) - 1.0).max() < 1e-3
        assert np.linalg.norm(morphed - expected, axis=1).max() < 0.1
        assert np.linalg.norm(morphed - expected, axis=1).mean() < 0.2 * np.linalg.norm(morphed - normals, axis=1).max()


def test_materials_do_not_multiply_morphs(tmp_path):
    """Twelve materials divide the vertices at their borders. The data of the morphs grow by that and no more."""
    sizes = []
    for number in (1, 12):
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        _skin, rig = baked(materials=number)
        glb = Glb(export(rig, tmp_path / f"{number}.glb"))
        assert len(glb.primitives()) == number
        positions = [primitive["attributes"]["POSITION"] for primitive in glb.primitives()]
        vertices = sum(glb.json["accessors"][index]["count"] for index in positions)
        sizes.append(glb.json["buffers"][0]["byteLength"] / vertices)
    assert sizes[1] < 1.2 * sizes[0]


@pytest.mark.skipif(
    not VALIDATOR, reason="NOT TESTED: set SINEW_GLTF_VALIDATOR to a folder after npm install gltf-validator"
)
@pytest.mark.parametrize("keys", [True, False])
def test_khronos_validator_finds_no_errors(keys, tmp_path):
    skin, rig = baked()
    if not keys:
        skin.shape_key_clear()
        skin.sinew.skin.baked_keys.clear()
        bake_bones(rig, frame_end=4)
    path = export(rig, tmp_path / "arm.glb")
    assert ("targets" in Glb(path).primitives()[0]) == keys
    done = subprocess.run(["node", "-e", VALIDATE, str(path)], cwd=VALIDATOR, text=True, capture_output=True, timeout=60)
    assert done.returncode == 0, done.stderr
    report = json.loads(done.stdout)
    assert report["numErrors"] == 0
    assert {message["code"] for message in report["messages"]} <= {"NODE_SKINNED_MESH_NON_ROOT"}


def test_a_mesh_without_keys_has_no_morphs(tmp_path):
    skin, rig = make_arm()
    add_muscle(rig, around=FLEXOR)
    bind(skin)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, 4
    bake_bones(rig, frame_end=4)
    glb = Glb(export(rig, tmp_path / "arm.glb"))
    assert "targets" not in glb.primitives()[0] and "weights" not in glb.json["meshes"][0]


@pytest.mark.slow  # 10 s: 150 keys of 4,800 vertices
def test_many_keys_are_sparse_and_the_file_is_at_most_twice_the_fbx(tmp_path):
    skin, rig = baked(rings=80, around=60, tolerance=0.015, most_keys=60, combinations=16)
    assert len(skin.data.shape_keys.key_blocks) > 140
    path, fbx = export(rig, tmp_path / "arm.glb"), export(rig, tmp_path / "arm.fbx", "FBX")
    glb = Glb(path)
    assert all("sparse" in glb.json["accessors"][index] for index in glb.targets())
    print("keys", len(skin.data.shape_keys.key_blocks) - 1, "glb", path.stat().st_size, "fbx", fbx.stat().st_size)
    # Blender 4.5 writes no normals of keys to FBX
    assert path.stat().st_size <= (2.0 if bpy.app.version >= (5, 0) else 2.6) * fbx.stat().st_size
