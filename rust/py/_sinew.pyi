"""The Rust core of Sinew as a Python module.

Conventions:

- Space is armature space (metres, right-handed, Z up as in Blender) unless a name says `mesh`.
- An array of matrices has shape (N, 4, 4), float32, C order, and is *column-major*: `m[i, c]` is column c. Blender's
  `pose.bones.foreach_get("matrix", ...)` fills such an array. Transpose the last two axes of a row-major stack.
- Lengths of arrays are letters: B bones, T tissues, V vertices, E edges, F triangles or frames.
- Every number is checked. A wrong type, shape, order, index, a NaN or a number beyond 1e18 raises a ValueError that
  names the argument, what was found and what is needed. Nothing is converted, and after an error nothing was written.
- All classes are frozen: their content is checked once, when they are created. They release the GIL while they compute.
- Pages of `docs/mathematics/` are cited as `mathematics/<page>, <section>`.
"""

from collections.abc import Sequence
from typing import Final, Literal, final

import numpy as np
from numpy.typing import NDArray

__version__: Final[str]

TissueKind = Literal["MUSCLE", "BONE", "STUFFING", "SPHERE"]
Anchoring = Literal["BLENDED", "NEAREST"]
MotionSource = Literal["SWELLING", "FULL"]
Skinning = Literal["LINEAR", "PRESERVE_VOLUME", "NONE"]
Energy = Literal["AS_RIGID_AS_POSSIBLE", "SPRINGS"]
Parameterisation = Literal["BALL", "SWING_TWIST", "XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"]
GoalKind = Literal["POSITION", "ORIENTATION", "LOOK_AT"]

class SinewError(ValueError):
    """An array is well-formed but its content is impossible; the message names the thing and what to do."""

@final
class Skeleton:
    """The rest pose of a rig: one matrix per bone. Each joint of a B-Bone counts as a bone.

    The skinning matrix of a bone is `pose @ rest^-1` (mathematics/muscles.md, Pose and attachments).

    names: one per bone, unique, for messages.
    parents: (B,) int32, index of the parent bone, -1 for a root; without cycles.
    rest: (B, 4, 4) float32, column-major, each invertible.
    Raises ValueError (array), SinewError (singular rest matrix, cycle of parents).
    """

    def __new__(cls, names: Sequence[str], parents: NDArray[np.int32], rest: NDArray[np.float32]) -> Skeleton: ...
    def __len__(self) -> int: ...

@final
class Tissue:
    """One tissue in the rest pose (mathematics/muscles.md, Tissues; Wilhelms 1997, sec. 3-4).

    kind:
      - MUSCLE: a belly between two tendons, from `origin_bone` to `insertion_bone`. It shortens, lengthens and
        bulges.
      - BONE: three ellipsoids along local z, rigid with `origin_bone`: a shaft over the whole length with 0.6 of
        the widths, and an end with the full widths on each side.
      - STUFFING, SPHERE: one ellipsoid, rigid with `origin_bone`. A sphere is at a joint, and muscles can wrap
        around it.
    origin_bone, insertion_bone: indices of bones of the skeleton; equal for a rigid kind.
    centre: (3,) m. rotation: quaternion (w, x, y, z); local z points from origin to insertion. semi_axes: (3,) m, above
    0.
    origin_tendon, insertion_tendon: m, 0 or more. The origin is at `centre - (semi_axes.z + origin_tendon) z`, the
    insertion at `centre + (semi_axes.z + insertion_tendon) z`.
    volume_keeping: 0..1.5; 1 keeps volume and width ratio exactly (mathematics/muscles.md, Volume keeping).
    via_points: (bone index, (x, y, z) m in the rest pose), from origin to insertion; muscles only. The path passes
    through them smoothly. Each moves with its bone.
    wraps: names of SPHERE tissues of the same musculature that the muscle wraps around, on the side where its rest path
    passes them; muscles only. The path is straight where it does not touch a sphere.
    A muscle with via points or wraps is *curved*: the length of its path replaces the distance from origin to
    insertion, and its belly is a chain of ellipsoids along the path. At rest the belly is as long as the path without
    the tendons.
    Raises SinewError that names the tissue, the value and the limit.
    """

    def __new__(
        cls,
        name: str,
        kind: TissueKind,
        origin_bone: int,
        insertion_bone: int,
        centre: Sequence[float],
        rotation: Sequence[float],
        semi_axes: Sequence[float],
        origin_tendon: float = 0.0,
        insertion_tendon: float = 0.0,
        volume_keeping: float = 1.0,
        *,
        via_points: Sequence[tuple[int, Sequence[float]]] = (),
        wraps: Sequence[str] = (),
    ) -> Tissue: ...
    @property
    def name(self) -> str: ...
    @property
    def volume(self) -> float:
        """Rest volume of the ellipsoids, m^3. For a muscle, of the belly; for a curved muscle, of the belly as if it
        were straight, because its path depends on spheres (see `PosedMusculature.volume`)."""

@final
class Musculature:
    """All tissues of one rig.

    Raises SinewError if a tissue is on a bone that is not in the skeleton, two tissues have the same name, or a muscle
    wraps around something that is not a SPHERE among the tissues.
    """

    def __new__(cls, skeleton: Skeleton, tissues: Sequence[Tissue]) -> Musculature: ...
    def __len__(self) -> int: ...
    @property
    def ellipsoid_count(self) -> int:
        """E, the number of ellipsoids of all tissues: 3 per bone, 5 per curved muscle, 1 for others."""
    @property
    def ellipsoid_tissue(self) -> NDArray[np.int32]:
        """(E,) index of the tissue of each ellipsoid, never decreasing."""
    def joints(self) -> list[tuple[int, tuple[float, float, float], bool]]:
        """The joints that muscles cross, each at the head of its child bone, ordered by child bone: (child bone, axis,
        bends one way).

        The axis is a unit vector, armature space at rest: the axis of the muscles' moments (mathematics/muscles.md,
        Joint axes). For a hinge that is bent at rest, a positive rotation bends it further, and it bends in that
        direction only.
        """
    def pose(self, pose: NDArray[np.float32], tension: NDArray[np.float32], out: NDArray[np.float32]) -> PosedMusculature:
        """The tissues in a pose.

        pose: (B, 4, 4) column-major.
        tension: (T,) 0..1. It thickens a muscle at constant volume and length: the belly loses up to 30 % of its length
        to the tendons. Rigid kinds ignore it.
        out: (T, 4, 4) column-major float32, written: unit sphere to posed tissue (the belly of a muscle, the envelope
        of a bone). At rest without tension this is the tissue's own matrix. A curved muscle is shown by one ellipsoid:
        its own, moved as the middle of the belly, with the belly's change of shape.
        """
    def pose_ellipsoids(self, pose: NDArray[np.float32], tension: NDArray[np.float32], out: NDArray[np.float32]) -> None:
        """All ellipsoids in a pose, for drawing: bones with their ends, curved muscles as chains.

        pose, tension: as for `pose`.
        out: (E, 4, 4) column-major float32, written: unit sphere to each ellipsoid, in the order of `ellipsoid_tissue`.
        The ellipsoids of a chain overlap; each keeps its fraction of the belly's volume.
        """
    def path_points(self, pose: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
        """Polylines along the muscles in a pose, from origin to insertion, for drawing.

        pose: (B, 4, 4) column-major.
        Returns points (P, 3) float32, armature space, m, and offsets (T + 1,) int32. Tissue t has
        `points[offsets[t]:offsets[t + 1]]`: none for a rigid kind, two for a straight muscle.
        """

@final
class ShownTissues:
    """The objects that show T tissues. Each is a child of a bone, and its own transform is the tissue in the rest pose.

    names: for messages.
    bones: (T,) int32, the parent bone of each.
    to_bones: (T, 4, 4) float32, column-major: from the space of the own transform to the axes of the bone, from its
    head.
    locations, scales: (T, 3) float32, of the own transform, m. rotations: (T, 4) float32, w first.
    orders: the rotation order of each: XYZ, XZY, YXZ, YZX, ZXY or ZYX, about fixed axes, the first letter first.
    Raises ValueError (array), SinewError (a matrix that is not invertible).
    """

    def __new__(
        cls,
        skeleton: Skeleton,
        names: Sequence[str],
        bones: NDArray[np.int32],
        to_bones: NDArray[np.float32],
        locations: NDArray[np.float32],
        rotations: NDArray[np.float32],
        scales: NDArray[np.float32],
        orders: Sequence[str],
    ) -> ShownTissues: ...
    def __len__(self) -> int: ...
    def deltas(self, pose: NDArray[np.float32], posed: NDArray[np.float32], out: NDArray[np.float32]) -> None:
        """The delta transform of each object that shows its posed tissue.

        pose: (B, 4, 4) column-major. posed: (T, 4, 4) column-major, as `Musculature.pose` writes it.
        out: (T, 13) float32, written: the delta location, which is added (3); the delta rotation, applied after the
        rotation, as a quaternion (4, w first) and as angles about x, y and z (3, rad); the delta scale, which
        multiplies (3). No change if the bone has no size.
        """

@final
class PosedMusculature:
    """The tissues in one pose. Arrays are read-only copies, in the order of the tissues."""

    @property
    def stretch(self) -> NDArray[np.float32]:
        """(T,) posed belly length / rest belly length; 1 for rigid kinds."""
    @property
    def volume(self) -> NDArray[np.float64]:
        """(T,) posed volume, m^3. For a curved muscle, of one ellipsoid as long as its belly; each ellipsoid of the
        chain keeps a fixed fraction of it."""
    @property
    def clamped(self) -> list[str]:
        """Names of the muscles whose belly is close to its minimum length (a tenth of its rest length)."""

@final
class Regional:
    """A setting of the skin that differs by region (Wilhelms 1997). At a vertex it is `body`, times the mean of the
    factors of its bones by their weights (1 without weights), times the factor of the vertex.

    body: the value for the whole body.
    bones: (B,) float32, one factor per bone; None is 1 everywhere.
    vertices: (V,) float32, one factor per vertex; None is 1 everywhere.
    All are 0 or more. The product has the unit of `body`.
    Raises ValueError (array). `Skin` raises, with the name of the setting, if values are negative or do not fit mesh or
    rig.
    """

    def __new__(
        cls,
        body: float = 1.0,
        bones: NDArray[np.float32] | None = None,
        vertices: NDArray[np.float32] | None = None,
    ) -> Regional: ...

@final
class Elasticity:
    """Elastic skin around the joints at which it bends: relaxation, volume constraint, crease planes
    and skin contact (mathematics/relaxation.md, volume.md, contact.md).

    spring_edges: (S, 2) int32, the edges of the mesh and the diagonals of its faces; the length springs of energy SPRINGS.
    Otherwise only edges count.
    triangles: (F, 3) int32, the triangulated faces.
    segments: (B,) int32; bones with the same number are one segment of the body (split and twist bones).
    bone_lengths: (B,) float32, m.
    iterations: iterations of the solver per frame, 0..1000.
    energy: AS_RIGID_AS_POSSIBLE keeps the shape around each vertex (Sorkine and Alexa 2007), SPRINGS the length of each
    edge (Wilhelms 1997).
    anchor_stiffness, edge_stiffness: factors on the stiffness of anchor springs and edges; None is 1.
    slack: the distance of a vertex from its anchor, m, below which it is not pulled back; None is 0.
    relaxation: fraction of the iterations that a vertex takes part in, at most 1; None is 1.
    fat_sliding: how freely skin slides along itself over what is below, 0..1; None is 0.
    volume, crease: (B,) float32, 0..1, strength of the volume constraint and of the crease plane of the joint at the
    head of each bone; None is 1.
    contact: (B,) float32, 0..1, strength of skin contact for the skin of each bone; None is 1.
    contacts: separate skin from other skin.
    safeguard: return a joint to the skin of the Armature modifier in rotations in which Sinew's skin has more inverted
    faces, more stretch or more intersections (mathematics/safeguard.md); not with SPRINGS.
    Raises ValueError (array, iterations, energy). `Skin` raises if values are outside their limits or do not fit mesh
    or rig.
    """

    def __new__(
        cls,
        spring_edges: NDArray[np.int32],
        triangles: NDArray[np.int32],
        segments: NDArray[np.int32],
        bone_lengths: NDArray[np.float32],
        iterations: int = 10,
        *,
        energy: Energy = "AS_RIGID_AS_POSSIBLE",
        anchor_stiffness: Regional | None = None,
        edge_stiffness: Regional | None = None,
        slack: Regional | None = None,
        relaxation: Regional | None = None,
        fat_sliding: Regional | None = None,
        volume: NDArray[np.float32] | None = None,
        crease: NDArray[np.float32] | None = None,
        contact: NDArray[np.float32] | None = None,
        contacts: bool = True,
        safeguard: bool = True,
    ) -> Elasticity: ...

@final
class Skin:
    """A mesh that is bound to a musculature in the rest pose, with its deformation and its correction
    (mathematics/binding.md; skinning.md, One frame; correction.md).

    musculature: the tissues.
    points: (V, 3) float32, the rest mesh in mesh space, basis shape. edges: (E, 2) int32.
    mesh_to_armature: (4, 4) float32 column-major, mesh space to armature space in the rest pose. It may be mirrored or
    scaled non-uniformly, but must be invertible.
    weight_offsets: (V + 1,) int32. weight_bones: (W,) int32. weights: (W,) float32, 0 or more. Vertex v has the bones
    `weight_bones[weight_offsets[v]:weight_offsets[v + 1]]`. Weights are divided by their sum, as in Blender. A vertex
    whose sum is at most 1e-4 does not move with bones.
    skinning: the Armature modifier: LINEAR, PRESERVE_VOLUME (dual quaternions), or NONE (no modifier).
    anchoring: BLENDED blends all near tissues, smoothed over the mesh. NEAREST uses the nearest tissue only, as the
    thesis does.
    motion_source: SWELLING moves the skin with the mesh's bone weights and adds the swelling of the tissues
    (mathematics/binding.md, Motion source). FULL moves it with the whole motion of the tissues, as in the literature.
    scale_fat: True scales the fat between tissue and skin with the tissue (Wilhelms' virtual anchor). False keeps its
    thickness (thesis).
    falloff: the distance from a tissue, m in armature space, at which its influence reaches 0. With FULL, a
    vertex without bone weights follows its tissues at any distance.
    softness: distance, m, that blurs the border between tissues (mathematics/binding.md, Influence weights).
    gain: factor on the swelling, 0 or more. muscle_influence: a factor by region; None is 1. Where the product is 0, no
    muscle moves the skin.
    elasticity: None leaves the skin at its anchors. With it, the skin around each joint that a muscle crosses and that
    is rotated from rest is relaxed in every frame, from the anchors of that frame only.
    preserved_fractions: (V,) float32, 0..1, how much of each vertex Preserve Volume moves; the rest is linear. None: as
    `skinning` says.
    body: the bound skin over which this one is worn; it must have the same musculature. With it, the skin is a garment: it
    follows the correction of the body, and tissues and elasticity do not act on it (mathematics/garments.md).
    body_triangles, triangles: (T, 3) int32, those of the body and of this mesh; all three or none.
    Raises ValueError (array), SinewError (values outside their limits, no vertices, no tissues).
    """

    def __new__(
        cls,
        musculature: Musculature,
        points: NDArray[np.float32],
        edges: NDArray[np.int32],
        mesh_to_armature: NDArray[np.float32],
        weight_offsets: NDArray[np.int32],
        weight_bones: NDArray[np.int32],
        weights: NDArray[np.float32],
        *,
        skinning: Skinning = "LINEAR",
        anchoring: Anchoring = "BLENDED",
        motion_source: MotionSource = "SWELLING",
        scale_fat: bool = False,
        falloff: float = 0.03,
        softness: float = 0.004,
        gain: float = 1.0,
        muscle_influence: Regional | None = None,
        elasticity: Elasticity | None = None,
        preserved_fractions: NDArray[np.float32] | None = None,
        body: Skin | None = None,
        body_triangles: NDArray[np.int32] | None = None,
        triangles: NDArray[np.int32] | None = None,
    ) -> Skin: ...
    def __len__(self) -> int: ...
    @property
    def anchored(self) -> int:
        """Number of vertices that at least one tissue moves; of a garment, those that follow the body."""
    @property
    def tissue_weights(self) -> NDArray[np.float32]:
        """(V, T) influence of each tissue on each vertex, for display. The sum of a row is 0..1 and decreases with the
        distance from the tissues."""
    def correct(self, pose: NDArray[np.float32], tension: NDArray[np.float32], out: NDArray[np.float32]) -> FrameReport:
        """The correction of one frame: the displacement of the rest points before the Armature modifier, mesh space, m.

        pose: (B, 4, 4) column-major. tension: (T,) 0..1.
        out: (V, 3) float32, written. Exactly 0 where no tissue is near and no rotated joint of an elastic skin. It
        depends on the arguments only.
        """
    def deform(self, pose: NDArray[np.float32], tension: NDArray[np.float32], out: NDArray[np.float32]) -> FrameReport:
        """The deformed skin of one frame, mesh space, m: the result of the Armature modifier with the correction.

        pose: (B, 4, 4) column-major. tension: (T,) 0..1.
        out: (V, 3) float32, written; must not be the array of the rest points.
        """

@final
class LinearSkin:
    """A mesh with linear blend skinning, as in game engines: each vertex moves to the weighted mean of the positions
    that its bones give it.

    skeleton: the bones. points: (V, 3) float32, the rest mesh, mesh space, m.
    mesh_to_armature, weight_offsets, weight_bones, weights: as for `Skin`.
    Raises ValueError (array), SinewError (no vertices, a matrix that is not invertible).
    """

    def __new__(
        cls,
        skeleton: Skeleton,
        points: NDArray[np.float32],
        mesh_to_armature: NDArray[np.float32],
        weight_offsets: NDArray[np.int32],
        weight_bones: NDArray[np.int32],
        weights: NDArray[np.float32],
    ) -> LinearSkin: ...
    def __len__(self) -> int: ...
    def deform(self, pose: NDArray[np.float32], offsets: NDArray[np.float32], out: NDArray[np.float32]) -> None:
        """The positions of the vertices in a pose, with `offsets` added to the rest points.

        pose: (B, 4, 4) column-major. offsets: (V, 3) float32. out: (V, 3) float32, written. All in mesh space, m.
        """
    def correct(self, pose: NDArray[np.float32], target: NDArray[np.float32], out: NDArray[np.float32]) -> int:
        """The displacement of the rest points for which the bones move the vertices to `target`.

        pose: (B, 4, 4) column-major. target: (V, 3) float32. out: (V, 3) float32, written. All in mesh space, m.
        Returns the number of vertices at which it is damped and bounded because the bones flatten them.
        """
    def fit(
        self, poses: NDArray[np.float32], targets: NDArray[np.float32], most: int, hold: float
    ) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.float32]]:
        """Bone weights with which the skin is nearest to `targets` (the weight step of Le and Deng, "Smooth Skinning
        Decomposition with Rigid Bones", 2012). Weights are 0 or more with a sum of 1 per vertex, on bones that the
        vertex has now.

        poses: (F, B, 4, 4) column-major. targets: (F, V, 3) float32, mesh space, m.
        most: most bones per vertex, 1 or more.
        hold: m. A weight changes by 1 only if that brings the vertex nearer by more than this on average, so that
        weights which the poses do not determine stay the same. Without poses the present weights are limited: the
        largest are kept and normalised.
        Returns weight_offsets, weight_bones and weights, as a `LinearSkin` takes them.
        """

@final
class FrameReport:
    """Conditions met in one frame."""

    @property
    def clamped(self) -> list[str]:
        """Names of the muscles close to their minimum length, as in `PosedMusculature.clamped`."""
    @property
    def damped(self) -> int:
        """Number of vertices whose bone transform is nearly singular, so that the correction is damped and bounded."""

@final
class RestSurface:
    """A triangulated skin in the rest pose, with which deformed states are compared, whatever deformed them
    (mathematics/quality.md).

    points: (V, 3) float32, m. triangles: (F, 3) int32, facing outwards. Faces without area, loose vertices, edges of
    three and more faces, and open surfaces are allowed.
    Raises ValueError (array, a corner that is not a vertex), SinewError (no vertices).
    """

    def __new__(cls, points: NDArray[np.float32], triangles: NDArray[np.int32]) -> RestSurface: ...
    @property
    def rest_hits(self) -> int:
        """Number of pairs of triangles that intersect at rest and share no vertex."""
    def region(
        self, centre: Sequence[float], radius: float, carried: NDArray[np.bool_] | None = None
    ) -> SurfaceRegion | None:
        """The skin around a joint: of the triangles whose rest centroid is closer to `centre` than `radius` (m) and
        that have one of the `carried` vertices ((V,) bool; None: all), the largest connected part; None if there is
        none."""
    def whole(self) -> SurfaceRegion:
        """The whole surface as one region."""
    def deformed(self, points: NDArray[np.float32]) -> DeformedSurface:
        """A deformed state: (V, 3) float32, m, in the space and order of the rest points."""

@final
class SurfaceRegion:
    """A part of a surface that is measured on its own; len() is its number of triangles."""

    def __len__(self) -> int: ...
    @property
    def faces(self) -> NDArray[np.int32]:
        """Its triangles, as indices of the surface's triangles, increasing."""
    @property
    def rest_union(self) -> float:
        """Occupied volume at rest, m^3. Each boundary loop is closed by a fan from its centre."""

@final
class DeformedSurface:
    """One deformed state of a surface."""

    def quality(self, region: SurfaceRegion) -> SkinQuality:
        """The quality of a region of the same surface. Raises ValueError for a region of another surface."""
    @property
    def inverted(self) -> NDArray[np.bool_]:
        """(F,) whether each triangle is inverted: its normal opposes its rest normal as rotated by the rigid fit of
        three rings of vertices around its corners."""
    @property
    def new_intersections(self) -> NDArray[np.int32]:
        """(N, 2) pairs of triangles that intersect, share no vertex and did not intersect at rest."""
    @property
    def vertex_stretch(self) -> NDArray[np.float32]:
        """(V,) length over rest length of the edge at each vertex that changed most; 1 at a loose vertex."""

@final
class SkinQuality:
    """The quality of one region in one deformed state. Ratios are over rest: 1 is unchanged. For a region that is flat
    at rest, volumes are 1, and overlap and inside_out are 0."""

    @property
    def union(self) -> float:
        """Occupied volume, by winding number along 200 x 200 rays in z, with the region closed over its boundary loops."""
    @property
    def overlap(self) -> float:
        """Volume that is occupied more than once, over the volume occupied at rest."""
    @property
    def inside_out(self) -> float:
        """Volume turned inside out, over the volume occupied at rest."""
    @property
    def unreadable(self) -> float:
        """Fraction, 0..1, of the rays whose crossings do not cancel, as at a hole. They are left out."""
    @property
    def volume(self) -> float:
        """Signed volume. Folds count twice, so a skin with folds scores too well."""
    @property
    def edge_p50(self) -> float:
        """Median over the edges of max(l / l0, l0 / l)."""
    @property
    def edge_p99(self) -> float:
        """99th percentile over the edges."""
    @property
    def edge_max(self) -> float:
        """Maximum over the edges."""
    @property
    def area_p99(self) -> float:
        """99th percentile over the triangles of max(A / A0, A0 / A)."""
    @property
    def inverted(self) -> int:
        """Number of inverted triangles, see `DeformedSurface.inverted`."""
    @property
    def new_intersections(self) -> int:
        """Number of new self-intersections with at least one triangle in the region."""
    @property
    def bend_p99(self) -> float:
        """99th percentile over the edges of the change of the angle between the two faces, degrees 0..180."""

@final
class KeptSamples:
    """A few samples of a moving skin whose cross-fade stays near all of them (mathematics/baking.md, Reduction of
    frames).

    Errors are distances on the posed skin, mesh space, m: the difference between corrections as the Armature modifier
    poses it.

    poses: (K, B, 4, 4) float32, column-major, as `Skin.correct` takes them. corrections: (K, V, 3) float32, m, in those
    poses.
    at: (K,) float64, increasing, such as frame numbers. tolerances: (K,) float64, m, the allowed error of each sample.
    candidates: (K,) bool, the samples that may be kept. The others only check the error.
    Each line extends as far as possible before the next sample is kept. An earlier sample, or no correction, is shown
    again where it is near enough.
    Raises ValueError (array), SinewError (`at` does not increase, a negative tolerance).
    """

    def __new__(
        cls,
        skin: Skin,
        poses: NDArray[np.float32],
        corrections: NDArray[np.float32],
        at: NDArray[np.float64],
        tolerances: NDArray[np.float64],
        candidates: NDArray[np.bool_],
    ) -> KeptSamples: ...
    @property
    def places(self) -> list[int]:
        """The samples at which one shape alone is shown. Between two of them both cross-fade; outside, the nearest
        stays."""
    @property
    def shown(self) -> list[int | None]:
        """The sample whose corrections are shown at each of `places`; None for no correction."""
    @property
    def errors(self) -> NDArray[np.float64]:
        """(K,) error of each sample, m."""

@final
class MotionKeys:
    """The corrective keys that one motion of a joint needs (mathematics/baking.md, Correctives): its samples from rest
    outward, each as far from the previous one as the tolerance allows.

    The tent weight of a key is 1 at its own value and linear down to 0 at its neighbours and at rest, 0. The outermost
    keys keep 1 beyond their value.

    poses: (K, B, 4, 4) float32, column-major. corrections: (K, V, 3) float32, m, in those poses.
    at: (K,) float64, increasing, with 0 (rest) among them. Errors are those of `KeptSamples`.
    tolerance: m, the allowed error of all samples. threshold: m; entries up to this length become 0.
    indices: the samples that become keys, increasing, without rest. None chooses them by the tolerance.
    Raises ValueError (array), SinewError (`at` does not increase or lacks 0).
    """

    def __new__(
        cls,
        skin: Skin,
        poses: NDArray[np.float32],
        corrections: NDArray[np.float32],
        at: NDArray[np.float64],
        tolerance: float,
        threshold: float,
        indices: list[int] | None = None,
    ) -> MotionKeys: ...
    def __len__(self) -> int: ...
    @property
    def at(self) -> list[float]:
        """The value of each key, increasing; never 0."""
    @property
    def indices(self) -> list[int]:
        """The sample of each key, increasing."""
    def correction(self, key: int) -> NDArray[np.float32]:
        """(V, 3) what a key adds at its value, m. Raises ValueError if there is no such key."""
    @property
    def error_at(self) -> float:
        """Largest error of the samples that are keys, m."""
    @property
    def error_between(self) -> float:
        """Largest error of all other samples, m."""

@final
class CombinationKeys:
    """The corrective keys that two motions together need beyond those of each, in one of the four quadrants around rest
    (mathematics/baking.md, Combinations).

    The weight of a key is the product of two tent weights. The first nodes are the outermost values. Then one more
    value is added at a time, the one that lowers the largest error most, while that is above the tolerance. All tents
    end at rest, 0.

    first, second: of the same mesh.
    first_at (F,), second_at (G,): float64, increasing, of one sign each. The outermost and every second one from there
    towards rest may become nodes; those between only check the error.
    poses: (F, G, B, 4, 4) float32, column-major. corrections: (F, G, V, 3) float32, m.
    tolerance, threshold: m. most: most keys.
    Raises ValueError (array), SinewError (values of both signs).
    """

    def __new__(
        cls,
        skin: Skin,
        first: MotionKeys,
        second: MotionKeys,
        first_at: NDArray[np.float64],
        second_at: NDArray[np.float64],
        poses: NDArray[np.float32],
        corrections: NDArray[np.float32],
        tolerance: float,
        threshold: float,
        most: int,
    ) -> CombinationKeys: ...
    def __len__(self) -> int: ...
    @property
    def first_at(self) -> list[float]:
        """The values of the first motion that are nodes, increasing, without rest."""
    @property
    def second_at(self) -> list[float]:
        """The same for the second motion."""
    @property
    def corners(self) -> list[tuple[int, int]]:
        """The index of each key in `first_at` and in `second_at`."""
    def correction(self, key: int) -> NDArray[np.float32]:
        """(V, 3) what a key adds where both tent weights are 1, m. Raises ValueError if there is no such key."""
    @property
    def error_before(self) -> float:
        """Largest error of all samples with the keys of the single motions only, m."""
    @property
    def error_at(self) -> float:
        """Largest error of the samples where both tent weights are 1, m."""
    @property
    def error_between(self) -> float:
        """Largest error of all other samples, m."""

@final
class SkinMotion:
    """Jitter and pop of a skin over a sequence of poses at equal small steps, relative to linear blend skinning in the
    same poses.

    frames, reference: (N, V, 3) float32, m. counted: (V,) bool, the vertices that count; None: all.
    Raises ValueError (array).
    """

    def __new__(
        cls,
        frames: NDArray[np.float32],
        reference: NDArray[np.float32],
        counted: NDArray[np.bool_] | None = None,
    ) -> SkinMotion: ...
    @property
    def jitter_p99(self) -> float:
        """99th percentile of |x(t-1) - 2 x(t) + x(t+1)|, m, over the vertices that move in the reference."""
    @property
    def jitter_reference_p99(self) -> float:
        """The same for the reference."""
    @property
    def jitter_excess_p99(self) -> float:
        """The same for the difference between the two."""
    @property
    def pop_max(self) -> float:
        """Longest motion of a vertex from one frame to the next, m."""
    @property
    def pop_reference_max(self) -> float:
        """The same for the reference."""
    @property
    def pop_excess(self) -> float:
        """Longest motion of a vertex relative to its reference from one frame to the next, m."""
    @property
    def pop_frame(self) -> int:
        """The frame before that motion."""
    @property
    def pop_vertex(self) -> int:
        """The vertex that moves so."""
    @property
    def pop_persistence(self) -> float:
        """The excess over one frame as a fraction of the excess over two: about 0.5 for continuous motion, near 1 at a
        jump."""

@final
class PolygonMesh:
    """The polygons of a mesh, in metres of the space that they are used in.

    points: (V, 3) float32, mesh space. corners: (C,) int32, the vertex of each corner, polygon after polygon. face_offsets:
    (F + 1,) int32, where the corners of each polygon start, then C; a polygon has 3 or more. to_space: (4, 4) float32,
    column-major, from mesh space to the space that it is used in; None for the same. `len` is F.
    A polygon of more than 3 corners is a fan of triangles around the mean of its corners, and so the same on the left and on
    the right of a symmetric body.
    Raises ValueError (array, offsets, a corner that is not a vertex), SinewError (a matrix that is not affine).
    """

    def __new__(
        cls,
        points: NDArray[np.float32],
        corners: NDArray[np.int32],
        face_offsets: NDArray[np.int32],
        to_space: NDArray[np.float32] | None = None,
    ) -> PolygonMesh: ...
    def __len__(self) -> int: ...

@final
class PlacedTissues:
    """Tissues placed on a body, before or after the fit under the skin (mathematics/fitting.md, Fit under the skin).

    kinds: one per tissue. centres: (T, 3) float64, armature space, m. rotations: (T, 4) float64, quaternions
    (w, x, y, z); local z points from origin to insertion. semi_axes: (T, 3) float64, m, above 0.
    tendons: (T, 2) float64, m, 0 or more: at the origin and at the insertion.
    via_points: (P, 3) float64, armature space, m. via_offsets: (T + 1,) int32. Tissue t has
    `via_points[via_offsets[t]:via_offsets[t + 1]]`, from origin to insertion.
    Each property is a new array of the shape above. `len` is T.
    Raises ValueError (array, kind, offsets), SinewError (a rotation of length 0, a semi-axis or tendon below its limit).
    """

    def __new__(
        cls,
        kinds: Sequence[TissueKind],
        centres: NDArray[np.float64],
        rotations: NDArray[np.float64],
        semi_axes: NDArray[np.float64],
        tendons: NDArray[np.float64],
        via_offsets: NDArray[np.int32],
        via_points: NDArray[np.float64],
    ) -> PlacedTissues: ...
    def __len__(self) -> int: ...
    @property
    def centres(self) -> NDArray[np.float64]: ...
    @property
    def rotations(self) -> NDArray[np.float64]: ...
    @property
    def semi_axes(self) -> NDArray[np.float64]: ...
    @property
    def tendons(self) -> NDArray[np.float64]: ...
    @property
    def via_offsets(self) -> NDArray[np.int32]: ...
    @property
    def via_points(self) -> NDArray[np.float64]: ...

@final
class SkinSurface:
    """The skin of one mesh or several in the rest pose, as one surface in one space, for rays, inside tests and nearest
    points (mathematics/fitting.md, Fit under the skin).

    Meshes may overlap. The normals of each mesh must agree with each other, and may all point inward. A ray from inside a
    limb first hits that limb's skin, however near the torso is. Results do not depend on the order of meshes and faces.
    Raises SinewError (a mesh without faces, no meshes).
    """

    def __new__(cls, meshes: Sequence[PolygonMesh]) -> SkinSurface: ...
    @property
    def size(self) -> float:
        """The longest side of the box around the skin, m."""
    @property
    def volume(self) -> float:
        """The volume of the body, m3, to about one part in a hundred."""
    @property
    def margin(self) -> float:
        """Margin between a fitted belly and the skin, m: 1-2 mm on a person."""
    def distances_along(self, origins: NDArray[np.float64], directions: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N,) float64: distance to the skin, in lengths of each direction; 0 from a point outside, NaN where the ray
        does not hit the skin.

        origins: (N, 3) float64, m. directions: (N, 3) float64, of any length.
        """
    def are_inside(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """(N,) bool: whether the skin encloses each of (N, 3) float64 points, m. At least two of three rays decide, so a
        hole does not matter. For closed meshes, this is where the winding number is above 0.
        """
    def nearest(self, points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The points of the skin nearest to (N, 3) float64 points inside or outside, m: (N, 3) float64, m, and their
        distances, (N,) float64, m.
        """
    def fit(self, tissues: PlacedTissues, left_twins: NDArray[np.int32]) -> PlacedTissues:
        """Each tissue sized to fit under the skin; unchanged where the skin does not cover it.

        left_twins: (T,) int32, the index of each tissue's twin on the left, -1 for none. A tissue becomes the exact mirror
        image of its fitted twin across x = 0 if both were placed as mirror images and their clearance is the same.
        Raises ValueError (array, a twin that is not a tissue).
        """
    def fill(
        self,
        tissues: PlacedTissues,
        volumes: NDArray[np.float64],
        fat: NDArray[np.float64],
        left_twins: NDArray[np.int32],
    ) -> PlacedTissues:
        """Fitted tissues, grown into the room that the body leaves.

        volumes: (T,) float64, the volume that each tissue should have, m3; 0 for as much as there is room.
        fat: (T,) float64, the depth of fat between each tissue and the skin, m.
        left_twins: as for `fit`; a tissue that is the exact mirror image of its twin stays one.
        Raises ValueError (array, a twin that is not a tissue).
        """
    def protrusions(self, tissues: PlacedTissues) -> NDArray[np.float64]:
        """(T,) float64: the distance by which each tissue protrudes from the skin, m; 0 if it does not."""

@final
class SurfaceTransfer:
    """Surface transfer: for each vertex of a new surface, the nearest point of the old one and its values
    (mathematics/fitting.md, Surface transfer).

    old, new: in one space. max_distance: m, 0 or more; a new vertex farther from the old surface takes no values.
    C is the number of corners of the old surface. N and G are the numbers of vertices and faces of the new one.
    Raises ValueError (`max_distance` is negative), SinewError (`old` has no faces).
    """

    def __new__(cls, old: PolygonMesh, new: PolygonMesh, max_distance: float) -> SurfaceTransfer: ...
    @property
    def is_near(self) -> NDArray[np.bool_]:
        """(N,) bool: whether the old surface is within `max_distance`."""
    @property
    def nearest_faces(self) -> NDArray[np.int32]:
        """(G,) int32: the old face nearest to the middle of each new face."""
    @property
    def nearest_corners(self) -> NDArray[np.int32]:
        """(N,) int32: the corner of the nearest old face with the largest weight, as an index of all corners."""
    def mixed(self, values: NDArray[np.float32]) -> NDArray[np.float32]:
        """(N, W) float32: weighted means of the values of the old surface's corners, (C, W) float32, for each new vertex.
        Weights are barycentric coordinates in the fan of the nearest face. 0 where the old surface is not near.
        """

@final
class Path:
    """A polyline with its arc length. points: (N, 3) float64, m, at least one."""

    def __new__(cls, points: NDArray[np.float64]) -> Path: ...
    @property
    def length(self) -> float:
        """Arc length, m."""
    def at(self, length: float) -> tuple[float, float, float]:
        """The point at that arc length, m; beyond its ends the path continues straight."""
    def nearest_length(self, point: Sequence[float]) -> float:
        """The arc length, m, at which the path is nearest to a point; of several the first."""

def nearest_on_segment(
    point: Sequence[float], start: Sequence[float], end: Sequence[float]
) -> tuple[tuple[float, float, float], float]:
    """The point of a segment nearest to `point`, m, and its fraction along the segment, 0 to 1. Points are (3,)."""
@final
class Progress:
    """The progress of a long computation, read and cancelled from another thread."""

    def __new__(cls) -> Progress: ...
    @property
    def done(self) -> float:
        """The completed fraction, 0..1."""
    def cancel(self) -> None:
        """Ends the computation soon, with a SinewError. A computation that starts with this object later ends at once."""

@final
class GrownSkin:
    """A skin grown over all tissues in the rest pose (mathematics/growing.md; Wilhelms 1997).

    musculature: T tissues on B bones.
    skin_thickness: (T,) float32, m, 0 or more: thickness of the skin over each tissue, added to `thickness`.
    bone_lengths: (B,) float32, m, along each bone's y axis.
    weight_bones: (B,) int32: for each bone the bone that gets its weight: itself, or its nearest ancestor that deforms
    meshes.
    resolution: voxels along the longest side, 4..8192. thickness: m.
    smoothing, radius, decay: passes (0..100) of a filter with a radius of 0..4 voxels and the weights e^(-decay d^2), d
    in voxels. Each voxel keeps its original depth where that is larger.
    faces: largest number of faces; None for the number that follows from the resolution.
    symmetric: make the result exactly symmetric about x = 0 wherever the tissues are, except for rounding.
    largest_only: remove all pieces but the largest.
    memory_limit_mb: if more is needed, an error says how much, before memory is allocated.
    progress: to read the progress and cancel from another thread.
    The surface is a closed manifold of quads for all tissues. It depends on the arguments only, bit for bit.
    Raises ValueError (array), SinewError (a value outside its limits, no tissues, memory, cancelled).
    """

    def __new__(
        cls,
        musculature: Musculature,
        skin_thickness: NDArray[np.float32],
        bone_lengths: NDArray[np.float32],
        weight_bones: NDArray[np.int32],
        *,
        resolution: int = 83,
        thickness: float = 0.0,
        smoothing: int = 5,
        radius: int = 1,
        decay: float = 1.0,
        faces: int | None = None,
        symmetric: bool = True,
        largest_only: bool = False,
        memory_limit_mb: float = 2000.0,
        progress: Progress | None = None,
    ) -> GrownSkin: ...
    def __len__(self) -> int:
        """V, the number of vertices."""
    @property
    def points(self) -> NDArray[np.float32]:
        """(V, 3) vertices, armature space, m."""
    @property
    def quads(self) -> NDArray[np.int32]:
        """(F, 4) corners of the faces, counter-clockwise seen from outside."""
    @property
    def weight_offsets(self) -> NDArray[np.int32]:
        """(V + 1,) where the weights of each vertex start, as `Skin` takes them; at most 4 per vertex, with a sum of 1."""
    @property
    def weight_bones(self) -> NDArray[np.int32]:
        """(W,) the bone of each weight."""
    @property
    def weights(self) -> NDArray[np.float32]:
        """(W,) the weights, the largest of each vertex first."""
    @property
    def voxel(self) -> float:
        """Edge length of a voxel of the lattice that the faces come from, m."""
    @property
    def thickened(self) -> list[str]:
        """Names of the tissues that were thickened because they protruded and were thinner than a voxel."""
    @property
    def pieces(self) -> int:
        """Number of connected pieces, before any was removed."""
    @property
    def worst_quality(self) -> float:
        """Quality of the worst face: 4 sqrt(3) area over the squared edges, of the worse triangle of a quad split along
        its better diagonal. 1 is equilateral. At least 0.1."""
    @property
    def protrusion(self) -> float:
        """Largest distance by which a point of the anatomy protrudes from the skin, m (100 points per ellipsoid)."""
    @property
    def protruding(self) -> str | None:
        """The tissue that protrudes most."""

def nearest_on_ellipsoid(semi_axes: Sequence[float], points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Nearest points on the surface of an ellipsoid at the origin with axes along x, y, z (mathematics/binding.md,
    Nearest point on an ellipsoid; Eberly 2013).

    semi_axes: (3,) above 0. points: (N, 3) float64, C order; at any position: inside, on an axis, at the centre (then
    the end of the shortest axis).
    Returns (N, 3) float64.
    """
@final
class Linkage:
    """The IK chain for `reach`: joints as a tree, from the body outward (mathematics/reach.md, Joints and limits).

    Armature space, m and rad, float64. Matrices are column-major.

    names: one per joint, unique.
    parents: (J,) int32, index of an earlier joint; -1 for a joint without a parent that moves.
    sockets: (J, 4, 4), axes and head of each bone at angles of 0, in the axes of the parent's posed bone (armature
    space without a parent). A bone points along its y axis.
    parameterisations: the meaning of a joint's three angles:
      - BALL: a rotation vector. It has no singular pose within a full rotation, which suits joints without limits.
      - SWING_TWIST: x and z are the rotation vector of a swing, y is the twist about the bone, which comes first.
        These are Blender's IK limits.
      - XYZ and the other orders: Euler angles as in Blender, the first axis rotates first.
    angles, lower, upper: (J, 3) rad (a large number for no limit). Equal limits lock an angle. Angles outside
    their limits are clamped.
    scales: (J, 3), along the axes of the bone, applied before its rotation.
    eagerness: (J,) 0.1..2.5, how much a joint prefers to rotate.
    turns_with_parent: False: the joint moves with its parent's bone but does not rotate with it; the linear part of its
    socket is then in armature space.
    Raises ValueError (array), SinewError that names the joint.
    """

    def __new__(
        cls,
        names: Sequence[str],
        parents: NDArray[np.int32],
        sockets: NDArray[np.float64],
        parameterisations: Sequence[Parameterisation],
        angles: NDArray[np.float64],
        lower: NDArray[np.float64],
        upper: NDArray[np.float64],
        *,
        scales: NDArray[np.float64] | None = None,
        eagerness: NDArray[np.float64] | None = None,
        turns_with_parent: Sequence[bool] | None = None,
    ) -> Linkage: ...
    def __len__(self) -> int: ...
    @property
    def freedom_count(self) -> int:
        """Number of angles that are not locked."""
    @property
    def angles(self) -> NDArray[np.float64]:
        """(J, 3) the start angles, within their limits."""
    def heads(self, angles: NDArray[np.float64]) -> NDArray[np.float64]:
        """(J, 3) positions of the joints at these angles (J, 3), armature space, m."""

@final
class Goal:
    """A target for the bone of one joint.

    kind and target:
      - POSITION: `point` moves to target, (3,) armature space.
      - ORIENTATION: the bone takes the rotation target, a quaternion (w, x, y, z), armature space.
      - LOOK_AT: `axis` of the bone, from `point` on, points at target, (3,) armature space.
    point: (3,) m in the axes of the posed bone, from its head (with its scale). axis: (3,) in the same axes; None for
    y.
    weight: 0 or more. A residual as long as the linkage counts as much as one of 1 rad.
    Raises ValueError. `reach` raises if the goal does not fit the linkage.
    """

    def __new__(
        cls,
        joint: int,
        kind: GoalKind,
        target: Sequence[float],
        *,
        point: Sequence[float] | None = None,
        axis: Sequence[float] | None = None,
        weight: float = 1.0,
    ) -> Goal: ...

@final
class Reached:
    """The result of a reach."""

    @property
    def angles(self) -> NDArray[np.float64]:
        """(J, 3) rad, exactly within the limits."""
    @property
    def misses(self) -> list[float]:
        """The residual of each goal: m for a position, rad otherwise."""
    @property
    def evaluations(self) -> int:
        """Number of evaluations of the cost."""

def reach(
    linkage: Linkage,
    goals: Sequence[Goal],
    preferred: NDArray[np.float64] | None = None,
    *,
    preference: float = 1e-3,
    restarts: int = 0,
) -> Reached:
    """The pose that meets the goals best, starting from the pose of the linkage (mathematics/reach.md; Zhao and Badler
    1994).

    preferred: (J, 3) the pose to keep where the goals leave a choice; None for the pose of the linkage.
    preference: weight of the preferred pose.
    restarts: number of restarts from other poses if goals are missed; 0 while dragging, so that nothing jumps.
    The same arguments give the same bits. Raises ValueError, SinewError.
    """

def reach_clip(
    linkages: Sequence[Linkage],
    goals: Sequence[Sequence[Goal]],
    *,
    preference: float = 1e-3,
    restarts: int = 0,
    smoothness: float = 0.01,
) -> list[Reached]:
    """The poses of consecutive frames: one linkage and its goals per frame, with the same joints and the same locks.

    Each frame prefers the pose of its linkage.
    smoothness: weight of the squared second differences of the angles; 0: each frame is solved from the one before
    only.
    Raises ValueError, SinewError.
    """

def joint_rotation(parameterisation: Parameterisation, angles: Sequence[float]) -> tuple[float, float, float, float]:
    """The rotation (w, x, y, z) of a joint at these angles, rad."""

def joint_angles(
    parameterisation: Parameterisation, rotation: Sequence[float], near: Sequence[float]
) -> tuple[float, float, float]:
    """The angles of a rotation (w, x, y, z) that are nearest to `near`, rad."""

def set_thread_count(count: int) -> None:
    """Sets the number of threads of the pool; 0 for one per core. Results have the same bits for any number. Raises
    ValueError."""
