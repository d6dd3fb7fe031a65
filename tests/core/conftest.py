"""A limb for tests of the binding: two bones, a muscle across the joint, a bone and a tube of skin, without bpy."""

from dataclasses import dataclass

import _sinew
import numpy as np
import pytest

AROUND, ALONG = 16, 24


def column_major(matrices):
    """Converts row-major matrices to the column-major float32 of the binding."""
    return np.ascontiguousarray(np.swapaxes(np.asarray(matrices, np.float64), -1, -2).astype(np.float32))


def rotation(axis, angle):
    """Row-major 4x4 rotation about `axis` by `angle`, in radians (Rodrigues)."""
    x, y, z = np.asarray(axis, float) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    matrix = np.eye(4)
    matrix[:3, :3] += np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return matrix


def translation(vector):
    matrix = np.eye(4)
    matrix[:3, 3] = vector
    return matrix


REST = np.stack([rotation((1, 0, 0), 0.4), translation((0, 0, 0.3)) @ rotation((1, 1, 0), 0.2)])


@dataclass(frozen=True)
class Limb:
    skeleton: _sinew.Skeleton
    tissues: list
    musculature: _sinew.Musculature
    mesh: dict
    triangles: np.ndarray

    def skin(self, **options):
        return _sinew.Skin(self.musculature, **self.mesh, **options)

    @property
    def rest(self):
        return column_major(REST)

    def bent(self, angle, after=None):
        """The pose with the lower bone rotated about its head, then `after` applied to both bones."""
        joint = translation((0, 0, 0.3)) @ rotation((0.2, 1, 0), angle) @ translation((0, 0, -0.3))
        posed = np.stack([REST[0], joint @ REST[1]])
        return column_major(posed if after is None else after @ posed)

    @property
    def relaxed(self):
        return np.zeros(len(self.tissues), np.float32)

    def out(self, fill=7.0):
        return np.full((AROUND * ALONG, 3), fill, np.float32)


def make_limb(around=AROUND, along=ALONG):
    skeleton = _sinew.Skeleton(["upper", "lower"], np.array([-1, 0], np.int32), column_major(REST))
    tissues = [
        _sinew.Tissue("flexor", "MUSCLE", 0, 1, (0.03, 0, 0.3), (1, 0, 0, 0), (0.02, 0.025, 0.1), 0.02, 0.03),
        _sinew.Tissue("humerus", "BONE", 0, 0, (0, 0, 0.15), (1, 0, 0, 0), (0.02, 0.02, 0.15)),
        _sinew.Tissue("elbow", "SPHERE", 1, 1, (0, 0, 0.3), (1, 0, 0, 0), (0.03, 0.03, 0.03)),
    ]
    ring, step = np.divmod(np.arange(around * along), around)
    angle, height = 2 * np.pi * step / around, 0.6 * ring / along
    points = np.stack([0.05 * np.cos(angle), 0.055 * np.sin(angle), height], axis=1).astype(np.float32)
    index = np.arange(around * along).reshape(along, around)
    rounds = np.stack([index, np.roll(index, -1, axis=1)], axis=-1).reshape(-1, 2)
    lines = np.stack([index[:-1], index[1:]], axis=-1).reshape(-1, 2)
    lower = np.clip((height - 0.25) / 0.1, 0, 1)
    mesh = {
        "points": points,
        "edges": np.concatenate([rounds, lines]).astype(np.int32),
        "mesh_to_armature": np.eye(4, dtype=np.float32),
        "weight_offsets": (2 * np.arange(len(points) + 1)).astype(np.int32),
        "weight_bones": np.tile(np.array([0, 1], np.int32), len(points)),
        "weights": (0.7 * np.stack([1 - lower, lower], axis=1)).astype(np.float32).ravel(),
    }
    a, b = index[:-1], np.roll(index[:-1], -1, axis=1)
    c, d = np.roll(index[1:], -1, axis=1), index[1:]
    triangles = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    return Limb(skeleton, tissues, _sinew.Musculature(skeleton, tissues), mesh, triangles.astype(np.int32))


def elasticity_of(limb, **changes):
    """The arrays of an `Elasticity`. Each bone is a separate segment."""
    arrays = {
        "spring_edges": limb.mesh["edges"],
        "triangles": limb.triangles,
        "segments": np.array([0, 1], np.int32),
        "bone_lengths": np.array([0.3, 0.3], np.float32),
    }
    return arrays | changes


@pytest.fixture(scope="session")
def limb():
    return make_limb()
