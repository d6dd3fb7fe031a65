"""The bodies of the figures, a tube with one joint and an arm with one curved muscle, and plane sections."""

import _sinew
import numpy as np


def column_major(matrices) -> np.ndarray:
    """Converts row-major matrices to the column-major float32 that the core takes."""
    return np.ascontiguousarray(np.swapaxes(np.array(matrices, np.float64), -1, -2), dtype=np.float32)


def translation(x: float, y: float, z: float) -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


def rotation_x(radians: float) -> np.ndarray:
    matrix, (cosine, sine) = np.eye(4), (np.cos(radians), np.sin(radians))
    matrix[1:3, 1:3] = [[cosine, -sine], [sine, cosine]]
    return matrix


def rotation_z(radians: float) -> np.ndarray:
    matrix, (cosine, sine) = np.eye(4), (np.cos(radians), np.sin(radians))
    matrix[:2, :2] = [[cosine, -sine], [sine, cosine]]
    return matrix


class Tube:
    """A closed tube along z, 0.8 m long, with two bones that meet in its middle. A bone points along its y axis."""

    def __init__(self, rings: int = 73, around: int = 40, radius: float = 0.05):
        self.rings, self.around, self.radius, length = rings, around, radius, 0.8
        angles = np.arange(around) * 2 * np.pi / around
        circle = radius * np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
        side = [circle + (0, 0, z) for z in np.linspace(0, length, rings)]
        self.points = np.concatenate([*side, [(0, 0, 0), (0, 0, length)]]).astype(np.float32)
        triangles, edges, last = [], set(), len(self.points) - 2
        for ring in range(rings - 1):
            for here in range(around):
                there = (here + 1) % around
                quad = [ring * around + here, ring * around + there, (ring + 1) * around + there, (ring + 1) * around + here]
                triangles += [quad[:3], [quad[0], quad[2], quad[3]]]
                edges |= {tuple(sorted((quad[corner], quad[(corner + 1) % 4]))) for corner in range(4)}
        for here in range(around):
            there, top = (here + 1) % around, (rings - 1) * around
            triangles += [[last, there, here], [last + 1, top + here, top + there]]
            edges |= {(here, last), (top + here, last + 1)}
        self.triangles, self.edges = np.array(triangles, np.int32), np.array(sorted(edges), np.int32)
        upright = rotation_x(np.pi / 2)
        self._rest = [upright, translation(0, 0, 0.4) @ upright]
        self._skeleton = _sinew.Skeleton(["upper", "lower"], np.array([-1, 0], np.int32), column_major(self._rest))
        shapes = [
            _sinew.Tissue("upper", "STUFFING", 0, 0, (0, 0, 0.2), (1, 0, 0, 0), (0.045, 0.045, 0.19)),
            _sinew.Tissue("lower", "STUFFING", 1, 1, (0, 0, 0.6), (1, 0, 0, 0), (0.045, 0.045, 0.19)),
        ]
        self.musculature = _sinew.Musculature(self._skeleton, shapes)
        weight = np.clip((self.points[:, 2] - 0.4) / 0.12 + 0.5, 0, 1)
        weight = weight * weight * (3 - 2 * weight)
        count = len(self.points)
        self._offsets = 2 * np.arange(count + 1, dtype=np.int32)
        self._bones = np.tile([0, 1], count).astype(np.int32)
        self._weights = np.stack([1 - weight, weight], axis=1).ravel().astype(np.float32)
        surface = _sinew.RestSurface(self.points, self.triangles)
        self._surface = surface
        region = surface.region((0, 0, 0.4), 0.2)
        assert region is not None, "the tube has skin around its joint"
        self._region = region

    def skin(self, iterations: int = 10, skinning: str = "LINEAR", elastic: bool = True, contacts: bool = True, **options):
        elasticity = None
        if elastic:
            segments, lengths = np.array([0, 1], np.int32), np.array([0.4, 0.4], np.float32)
            elasticity = _sinew.Elasticity(
                self.edges, self.triangles, segments, lengths, iterations, contacts=contacts, **options
            )
        return self._bound(skinning=skinning, elasticity=elasticity)

    def influences(self, anchoring: str) -> np.ndarray:
        """(vertices, 2): the influence of two tissues that overlap in the middle."""
        shapes = [
            _sinew.Tissue("one", "STUFFING", 0, 0, (0, 0, 0.29), (1, 0, 0, 0), (0.045, 0.045, 0.14)),
            _sinew.Tissue("two", "STUFFING", 1, 1, (0, 0, 0.51), (1, 0, 0, 0), (0.045, 0.045, 0.14)),
        ]
        return self._bound(_sinew.Musculature(self._skeleton, shapes), anchoring=anchoring).tissue_weights

    def _bound(self, musculature=None, **options):
        weights = self._offsets, self._bones, self._weights
        mesh = self.points, self.edges, column_major(np.eye(4))
        return _sinew.Skin(musculature or self.musculature, *mesh, *weights, **options)

    def pose(self, degrees: float, kind: str = "bend") -> np.ndarray:
        rotation = rotation_x(np.radians(degrees)) if kind == "bend" else rotation_z(np.radians(degrees))
        return column_major([self._rest[0], translation(0, 0, 0.4) @ rotation @ rotation_x(np.pi / 2)])

    def deformed(self, skin, degrees, kind: str = "bend") -> np.ndarray:
        out = np.empty_like(self.points)
        skin.deform(self.pose(degrees, kind), np.zeros(2, np.float32), out)
        return out

    def quality(self, posed: np.ndarray):
        return self._surface.deformed(posed).quality(self._region)

    def normals(self, posed: np.ndarray) -> np.ndarray:
        """The unit normal of each vertex."""
        points, sums = posed.astype(np.float64), np.zeros(posed.shape)
        a, b, c = (points[self.triangles[:, corner]] for corner in range(3))
        for corner in range(3):
            np.add.at(sums, self.triangles[:, corner], np.cross(b - a, c - a))
        return sums / np.linalg.norm(sums, axis=1, keepdims=True)

    def least_radius(self, posed: np.ndarray) -> float:
        """The smallest mean radius of a ring, divided by the rest radius."""
        rings = posed[: self.rings * self.around].reshape(self.rings, self.around, 3)
        radii = np.linalg.norm(rings - rings.mean(axis=1, keepdims=True), axis=2).mean(axis=1)
        return float(radii.min() / self.radius)


def arm(degrees: float):
    """An arm in the plane x = 0 with a joint sphere and an extensor that wraps around it: its musculature and a pose."""
    rest = [np.eye(4), translation(0, 0.3, 0)]
    skeleton = _sinew.Skeleton(["upper", "lower"], np.array([-1, 0], np.int32), column_major(rest))
    # the rotation that takes the local z of the muscle to y, from the upper arm to the lower arm
    along = (np.cos(np.pi / 4), -np.sin(np.pi / 4), 0.0, 0.0)
    shapes = [
        _sinew.Tissue("elbow", "SPHERE", 0, 0, (0, 0.3, 0), (1, 0, 0, 0), (0.04, 0.04, 0.04)),
        _sinew.Tissue(
            "extensor", "MUSCLE", 0, 1, (0, 0.18, -0.05), along, (0.022, 0.022, 0.11), 0.03, 0.09, wraps=("elbow",)
        ),
    ]
    musculature = _sinew.Musculature(skeleton, shapes)
    return musculature, column_major([rest[0], translation(0, 0.3, 0) @ rotation_x(np.radians(degrees))])


def links_of() -> list[tuple[float, float]]:
    """Centre and half length of each ellipsoid of a belly chain, divided by the belly's half length.

    The constants are those of rust/core/src/muscles/belly_chain.rs.
    """
    return [(-0.64, 0.33), (-0.33, 0.45), (0.0, 0.45), (0.33, 0.45), (0.64, 0.33)]


def section(points: np.ndarray, triangles: np.ndarray) -> list[np.ndarray]:
    """The lines in which the plane x = 0 cuts a mesh, as (points, 2) arrays of y and z."""
    shifted = points[:, 0].astype(np.float64) + 1e-7
    segments = []
    for corners in triangles:
        heights = shifted[corners]
        if heights.min() > 0 or heights.max() < 0:
            continue
        ends = []
        for a, b in ((0, 1), (1, 2), (2, 0)):
            if (heights[a] > 0) != (heights[b] > 0):
                t = heights[a] / (heights[a] - heights[b])
                ends.append(points[corners[a], 1:] * (1 - t) + points[corners[b], 1:] * t)
        if len(ends) == 2:
            segments.append(np.array(ends))
    return _joined(segments)


def _joined(segments: list[np.ndarray]) -> list[np.ndarray]:
    """Joins segments with common ends into lines."""
    at: dict[tuple, list[tuple[int, int]]] = {}

    def key(point: np.ndarray) -> tuple[float, ...]:
        return tuple(np.round(point, 7).tolist())

    for number, ends in enumerate(segments):
        for side in (0, 1):
            at.setdefault(key(ends[side]), []).append((number, side))
    left, lines = set(range(len(segments))), []
    while left:
        number = min(left)
        left.remove(number)
        line = [segments[number][0], segments[number][1]]
        while True:
            follow = [(other, side) for other, side in at[key(line[-1])] if other in left]
            if not follow:
                break
            other, side = follow[0]
            left.remove(other)
            line.append(segments[other][1 - side])
        lines.append(np.array(line))
    return lines
