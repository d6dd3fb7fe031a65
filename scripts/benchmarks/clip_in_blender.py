"""Measures how far Sinew's correction of a vertex jumps between two frames of a clip while the skin there hardly moves.

usage: python3 scripts/run_in_blender.py scripts/benchmarks/clip_in_blender.py FILE CLIP.bvh LAST [safeguard_off]

FILE has a rigged character whose bones have the names of the clip's joints. Of a clip at 120 frames a second, every fourth
frame up to LAST is shown, with automatic muscles. Vertices that move by 10 mm or more under the Armature modifier alone do
not count.
"""

import sys
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix

from benchmarks.harm_in_blender import Skin, deform, meshes_of, positions, put_at_rest
from benchmarks.recognition_table import load

EVERY = 4
MOST_MOTION_M = 0.010
LARGEST_SHOWN = 10


class Clip:
    """A clip, and the rig that follows it by the rotations of its joints in space."""

    def __init__(self, rig, path: Path):
        self.rig = rig
        bpy.ops.import_anim.bvh(filepath=str(path), global_scale=0.01)
        self.joints = bpy.context.object
        self.rest = {bone.name: self._rotation(bone.matrix_local) for bone in self.joints.data.bones}

    def _rotation(self, matrix) -> Matrix:
        return (self.joints.matrix_world @ matrix).to_3x3().normalized()

    def show(self, frame: int) -> None:
        bpy.context.scene.frame_set(frame)
        turned = {None: Matrix.Identity(3)}
        for bone in self.rig.data.bones:  # parents first
            above = turned[bone.parent.name if bone.parent else None]
            turned[bone.name] = above
            if bone.name in self.rest:
                posed = self._rotation(self.joints.pose.bones[bone.name].matrix)
                turned[bone.name] = posed @ self.rest[bone.name].inverted()
            rest = bone.matrix_local.to_3x3()
            turn = rest.inverted() @ above.inverted() @ turned[bone.name] @ rest
            self.rig.pose.bones[bone.name].matrix_basis = turn.to_4x4()
        bpy.context.view_layer.update()


def main(file: str, clip_file: str, last: int, safeguard: bool) -> None:
    rig = load(Path(file))
    put_at_rest(rig)
    skin = Skin(meshes_of(rig)[0])
    deform(rig, [skin.mesh], "auto")
    skin.mesh.sinew.skin.safeguard = safeguard
    clip = Clip(rig, Path(clip_file))
    jumps, before = [], None
    for frame in range(1, last + 1, EVERY):
        clip.show(frame)
        alone = positions(skin.alone)
        correction = positions(skin.mesh) - alone
        if before is not None:
            still = np.linalg.norm(alone - before[0], axis=1) < MOST_MOTION_M
            jump = np.linalg.norm(correction - before[1], axis=1) * still
            jumps.append((1000.0 * float(jump.max()), frame, int(jump.argmax())))
        before = (alone, correction)
    sizes = [jump for jump, _, _ in jumps]
    above = sum(size > 1000.0 * MOST_MOTION_M for size in sizes)
    print(
        f"{len(jumps)} steps; of the largest jump in a step, mm: median {np.median(sizes):.1f}, "
        f"99th percentile {np.percentile(sizes, 99):.1f}, largest {max(sizes):.1f}; above 10 mm in {above}"
    )
    for jump, frame, vertex in sorted(jumps, reverse=True)[:LARGEST_SHOWN]:
        print(f"  frame {frame}, vertex {vertex}: {jump:.1f} mm")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]), "safeguard_off" not in sys.argv[4:])
