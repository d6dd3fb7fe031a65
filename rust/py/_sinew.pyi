"""The Rust core of Sinew, seen from Python.

Arrays cross this border, bpy never does. Conventions, everywhere:

- Space is the armature's own (metres, right-handed, Z up as in Blender) unless a name says `mesh`.
- A matrix array has shape (N, 4, 4), float32, C order, and is *column-major*: `m[i, c]` is column c. That is what
  Blender's `pose.bones.foreach_get("matrix", ...)` fills in; transpose the last two axes of a row-major stack.
- Every array is checked at the border: a wrong type, shape, order, NaN or index is a `ValueError` that names the
  argument, what was found and what is needed. Nothing is converted silently and nothing is written on an error.
- All classes are frozen: what they hold was checked once, when they were made. The GIL is released while they compute.
"""

from collections.abc import Sequence
from typing import Final, Literal, final

import numpy as np
from numpy.typing import NDArray

__version__: Final[str]

TissueKind = Literal["MUSCLE", "BONE", "STUFFING", "SPHERE"]
Anchoring = Literal["BLENDED", "NEAREST"]
Carry = Literal["SWELLING", "FULL"]
Skinning = Literal["LINEAR", "PRESERVE_VOLUME", "NONE"]
Energy = Literal["AS_RIGID_AS_POSSIBLE", "SPRINGS"]
Freedoms = Literal["BALL", "SWING_TWIST", "XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"]
GoalKind = Literal["POSITION", "ORIENTATION", "LOOK_AT"]

class SinewError(ValueError):
    """An input that is well-formed as an array but impossible as anatomy; the message names the thing and the remedy."""

@final
class Skeleton:
    """The rest pose of a rig: one frame of reference a bone (a B-Bone joint is a frame of its own).

    ALGORITHM 1: `B = pose @ rest^-1` carries a bone's rest space to the pose.

    names: one a bone, for messages, unique. parents: (B,) int32, -1 for a root, otherwise the index of another bone (no
    cycle). rest: (B, 4, 4) float32, column-major, each invertible.
    Raises ValueError (array), SinewError (singular rest matrix, cyclic parents).
    """

    def __new__(cls, names: Sequence[str], parents: NDArray[np.int32], rest: NDArray[np.float32]) -> Skeleton: ...
    def __len__(self) -> int: ...

@final
class Tissue:
    """One ellipsoid tissue in the rest pose (thesis 3.3; Wilhelms 1997 sec. 3-4).

    kind:
      - MUSCLE: a belly between two tendons, from `origin_bone` to `insertion_bone`; shortens, lengthens and bulges.
      - BONE: three ellipsoids along local z (a shaft of 0.6 of the widths over the whole length, and an end at either
        side with the full widths), rigid with `origin_bone`.
      - STUFFING, SPHERE: one ellipsoid, rigid with `origin_bone`; a sphere sits at a joint and never bulges.
    origin_bone, insertion_bone: indices into the skeleton; a rigid kind has both the same.
    centre: (3,) m. rotation: quaternion (w, x, y, z), local z runs from origin to insertion. semi_axes: (3,) m, > 0.
    origin_tendon, insertion_tendon: m, >= 0: the muscle's origin is at `centre - (semi_axes.z + origin_tendon) z`, its
    insertion at `centre + (semi_axes.z + insertion_tendon) z`.
    volume_keeping: p of ALGORITHM 2, 0..1.5; 1 keeps volume and width ratio exactly.
    via_points: (bone index, (x, y, z) m in the rest pose), ordered from origin to insertion; muscles only. The path
    goes smoothly through them, each carried by its bone.
    wraps: names of SPHERE tissues of the same musculature that the muscle goes round, on the side where its rest path
    passes them; muscles only. Where a sphere is not in the way the path is straight.
    A muscle with either is *curved*: the length of its path stands for |insertion - origin|, its belly is a chain of
    ellipsoids along it. In the rest pose the belly is as long as the path less the tendons, with these widths.
    Raises SinewError naming the tissue, the value and the limit.
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
        """Rest volume of the tissue's ellipsoids, m^3 (of the belly, for a muscle; of a curved one as if it were straight:
        its path depends on spheres, see `PosedMusculature.volume`)."""

@final
class Musculature:
    """All tissues of one rig.

    Raises SinewError when a tissue names a bone the skeleton has not (index out of range), two tissues share a name, or
    a muscle wraps something that is no SPHERE among the tissues.
    """

    def __new__(cls, skeleton: Skeleton, tissues: Sequence[Tissue]) -> Musculature: ...
    def __len__(self) -> int: ...
    @property
    def ellipsoid_count(self) -> int:
        """E, the number of ellipsoids of all tissues: 3 a bone, 5 a curved muscle, 1 any other."""
    @property
    def ellipsoid_tissue(self) -> NDArray[np.int32]:
        """(E,) index of the tissue of each ellipsoid, rising."""
    def joints(self) -> list[tuple[int, tuple[float, float, float], bool]]:
        """The joints that muscles cross, each at the head of its child bone, in the order of those: (child bone, axis, bends
        one way). The axis, unit, armature space at rest, is that of the muscles' moments there; of a hinge that is bent
        at rest, a positive turn bends it further, and it bends that way alone."""
    def pose(
        self, pose: NDArray[np.float32], tension: NDArray[np.float32], out: NDArray[np.float32]
    ) -> PosedMusculature:
        """The tissues in a pose.

        pose: (B, 4, 4) column-major. tension: (T,) 0..1, thickens a muscle at unchanged length: the belly gives up to
        30 % of its length to the tendons, at constant volume; ignored by rigid kinds.
        out: (T, 4, 4) column-major float32, written: the unit sphere to the posed tissue (belly, or the envelope of a
        bone); at rest, with no tension, this is the tissue's own matrix. Of a curved muscle it is one ellipsoid that
        stands for the chain: the tissue's own, moved as the middle of the belly moved, with the belly's change of shape.
        """
    def pose_ellipsoids(
        self, pose: NDArray[np.float32], tension: NDArray[np.float32], out: NDArray[np.float32]
    ) -> None:
        """All ellipsoids in a pose, for drawing: bones with their ends, curved muscles as chains.

        pose, tension: as for `pose`. out: (E, 4, 4) column-major float32, written: the unit sphere to each ellipsoid, in
        the order of `ellipsoid_tissue`. A chain's ellipsoids overlap; each keeps its share of the belly's volume.
        """
    def path_points(self, pose: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
        """Polylines along the muscles in a pose, from origin to insertion, for drawing.

        pose: (B, 4, 4) column-major. Returns points (P, 3) float32, armature space, and offsets (T + 1,) int32: tissue t
        has `points[offsets[t]:offsets[t + 1]]`: none for a rigid kind, two for a straight muscle.
        """

@final
class ShownTissues:
    """The objects that show T tissues. Each hangs on a bone, and its own transform is the tissue in the rest pose.

    names: for messages. bones: (T,) int32, the frame that each hangs on. to_bones: (T, 4, 4) float32, column-major: the
    space of the own transform in that bone's axes, from its head. locations, scales: (T, 3) float32, of the own transform,
    m. rotations: (T, 4) float32, w first. orders: the order of each one's angles, XYZ, XZY, YXZ, YZX, ZXY or ZYX, about
    fixed axes, the first named first.
    Raises ValueError where a matrix can't be inverted, or the skeleton has no such bone.
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
        """What each adds to its own transform to show its posed tissue.

        pose: (B, 4, 4) column-major. posed: (T, 4, 4) column-major, as `Musculature.pose` writes it. out: (T, 13) float32,
        written: what is added to the location (3), what turns after the rotation as a quaternion (4, w first) and the same
        as angles about x, y and z (3, rad), what multiplies the scale (3); what leaves it alone where its bone has no size.
        """

@final
class PosedMusculature:
    """What one pose did to each tissue. Arrays are read-only copies, in the order of the tissues."""

    @property
    def stretch(self) -> NDArray[np.float32]:
        """(T,) posed belly length / rest belly length; 1 for rigid kinds."""
    @property
    def volume(self) -> NDArray[np.float64]:
        """(T,) posed volume, m^3; of a curved muscle that of the one ellipsoid as long as its belly, of which each
        ellipsoid of the chain keeps a fixed share."""
    @property
    def clamped(self) -> list[str]:
        """Names of the muscles whose belly would be shorter than its floor (a tenth of its rest length)."""

@final
class Regional:
    """A setting of the skin that differs from region to region (Wilhelms 1997): at a vertex it is `body` times the
    mean of the factors of its bones, by its weights (1 where it has none), times its own factor.

    body: the whole body's value. bones: (B,) float32, a factor each; None is 1 everywhere. vertices: (V,) float32, a factor
    each; None is 1 everywhere. All are finite and >= 0; the product has the unit of `body`.
    Raises ValueError (array). What is below 0 or does not fit mesh or rig is told, by the setting's name, where a `Skin` is
    made with it.
    """

    def __new__(
        cls,
        body: float = 1.0,
        bones: NDArray[np.float32] | None = None,
        vertices: NDArray[np.float32] | None = None,
    ) -> Regional: ...

@final
class Elasticity:
    """What makes a skin elastic around the joints that it bends at (ALGORITHM 5 and 8): relaxation, regional volume, crease
    planes, and skin that keeps off tissues and off other skin.

    struts: (S, 2) int32, the mesh's edges and the diagonals of its faces, which springs lie along where they are the energy
    (else along edges). triangles: (F, 3) int32, its faces cut.
    segments: (B,) int32, bones of one number are one segment of the body (split and twist bones). bone_lengths: (B,)
    float32, m. iterations: rounds of relaxation a frame, 0..1000.
    energy: what relaxed skin keeps: AS_RIGID_AS_POSSIBLE its shape around each vertex (Sorkine and Alexa 2007), SPRINGS
    the length of each edge (Wilhelms).
    anchor_stiffness, edge_stiffness: factors on how firmly a vertex holds on to its anchor, and to its neighbours; None is 1.
    rest_distance: m, how far a vertex may lie from its anchor before it is pulled there; None is 0.
    relaxation: share of the iterations that a vertex takes part in, above 1 counts as 1; None is 1.
    fat_sliding: how freely skin slides along itself over what lies beneath, 0 not at all, above 1 counts as 1; None is 0.
    volume, crease: (B,) float32, 0..1, how fully the joint at the head of each bone keeps its volume, and its crease plane
    acts. contact: (B,) float32, 0..1, how fully the skin of each bone keeps off other skin. None is 1 everywhere.
    collides: tissues push the skin out. contacts: skin pushes other skin away.
    Raises ValueError (array, iterations, energy). What does not fit mesh or rig, or is outside its limits, is told where a
    `Skin` is made with it.
    """

    def __new__(
        cls,
        struts: NDArray[np.int32],
        triangles: NDArray[np.int32],
        segments: NDArray[np.int32],
        bone_lengths: NDArray[np.float32],
        iterations: int = 10,
        *,
        energy: Energy = "AS_RIGID_AS_POSSIBLE",
        anchor_stiffness: Regional | None = None,
        edge_stiffness: Regional | None = None,
        rest_distance: Regional | None = None,
        relaxation: Regional | None = None,
        fat_sliding: Regional | None = None,
        volume: NDArray[np.float32] | None = None,
        crease: NDArray[np.float32] | None = None,
        contact: NDArray[np.float32] | None = None,
        collides: bool = True,
        contacts: bool = True,
    ) -> Elasticity: ...

@final
class Skin:
    """A mesh bound to a musculature in the rest pose (ALGORITHM 3), and its deformation (4) and correction (6).

    musculature: the tissues.
    points: (V, 3) float32, the rest mesh in its own (mesh) space, basis shape. edges: (E, 2) int32.
    mesh_to_armature: (4, 4) float32 column-major, mesh space to armature space in the rest pose; may scale unevenly or
    mirror, must be invertible.
    weight_offsets: (V + 1,) int32, weight_bones: (W,) int32, weights: (W,) float32 >= 0: vertex v is weighed by
    `weight_bones[weight_offsets[v]:weight_offsets[v + 1]]`. Sums need not be 1: they are divided out as Blender does; a
    vertex whose sum is <= 1e-4 does not move with bones.
    skinning: what the Armature modifier does: LINEAR, PRESERVE_VOLUME (dual quaternions), or NONE (no modifier).
    anchoring: BLENDED weighs all near tissues, smoothed over the mesh; NEAREST takes the nearest one, as the thesis does.
    carry: SWELLING carries the skin with the mesh's own weights and adds each tissue's change of widths (ALGORITHM 3);
    FULL carries it with the tissues' whole motion (the papers).
    scale_fat: True scales the fat between tissue and skin with the tissue (Wilhelms' virtual anchor), False keeps its
    thickness (thesis).
    reach: m (armature space), the distance from a tissue at which its influence has fallen to 0. A vertex without any
    weight of its own, under FULL, follows its tissues at any distance.
    softness: m, the epsilon of ALGORITHM 3's blending weights.
    gain: factor on the swelling, >= 0. muscle_influence: another one, from region to region; None is 1. Where their product
    is 0 no muscle moves the skin.
    elasticity: None leaves the skin where weights and tissues bring it. With it, the skin around each joint that a muscle
    crosses, and that is turned from rest, is relaxed in every frame, from that frame's anchors alone.
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
        carry: Carry = "SWELLING",
        scale_fat: bool = False,
        reach: float = 0.03,
        softness: float = 0.004,
        gain: float = 1.0,
        muscle_influence: Regional | None = None,
        elasticity: Elasticity | None = None,
    ) -> Skin: ...
    def __len__(self) -> int: ...
    @property
    def anchored(self) -> int:
        """Number of vertices that at least one tissue moves."""
    @property
    def tissue_weights(self) -> NDArray[np.float32]:
        """(V, T) influence of each tissue on each vertex; a row sums to how near the tissues are, 0..1. For display."""
    def correct(
        self, pose: NDArray[np.float32], tension: NDArray[np.float32], out: NDArray[np.float32]
    ) -> FrameReport:
        """The correction of one frame: what to add to the rest points, in mesh space, before the Armature modifier.

        out: (V, 3) float32, written. Exactly 0 where no tissue is near, nor a turned joint of an elastic skin. Depends on nothing but the arguments.
        """
    def deform(
        self, pose: NDArray[np.float32], tension: NDArray[np.float32], out: NDArray[np.float32]
    ) -> FrameReport:
        """The deformed skin of one frame, in mesh space, as it stands after the Armature modifier.

        out: (V, 3) float32, written; may not be the rest points' own array.
        """

@final
class LinearSkin:
    """A mesh that bones carry by their weights and nothing else, as game engines do: each vertex goes to the weighted mean of
    where its bones take it.

    skeleton: the bones. points: (V, 3) float32, the rest mesh, mesh space. mesh_to_armature, weight_offsets, weight_bones,
    weights: as for `Skin`.
    Raises ValueError (array), SinewError (no vertices, a matrix that can't be inverted).
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
        """Where the vertices stand once `offsets` are added to their rest points.

        pose: (B, 4, 4) column-major. offsets: (V, 3) float32. out: (V, 3) float32, written. All mesh space, m.
        """
    def correct(self, pose: NDArray[np.float32], target: NDArray[np.float32], out: NDArray[np.float32]) -> int:
        """What to add to the rest points so that the bones take them to `target`.

        pose: (B, 4, 4) column-major. target: (V, 3) float32. out: (V, 3) float32, written. All mesh space, m. Returns at
        how many vertices it is damped and bounded, because the bones flatten them there.
        """
    def fit(
        self, poses: NDArray[np.float32], targets: NDArray[np.float32], most: int, hold: float
    ) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.float32]]:
        """Weights that bring the skin nearest to targets (weights' step of Le and Deng, "Smooth Skinning Decomposition with
        Rigid Bones", 2012): none below 0, summing to 1 at each vertex, of the bones that weigh there now.

        poses: (F, B, 4, 4) column-major. targets: (F, V, 3) float32, mesh space, m. most: bones a vertex, 1 or more. hold: m;
        a weight is changed by 1 only where that brings the vertex nearer by more than this in the mean, so that what the poses
        do not tell stays as it was. Without poses the present weights are limited: the strongest are kept and normalised.
        Returns weight_offsets, weight_bones and weights, as a `LinearSkin` takes them.
        """

@final
class FrameReport:
    """What one frame met."""

    @property
    def clamped(self) -> list[str]:
        """Muscles shortened to their floor, as in `PosedMusculature.clamped`."""
    @property
    def damped(self) -> int:
        """Vertices whose bone transform could hardly be inverted, so that the correction is damped and bounded."""

@final
class RestSurface:
    """A triangulated skin in the rest pose, that deformed states of it, by any deformer, are measured against.

    points: (V, 3) float32, m. triangles: (F, 3) int32, oriented outwards. Faces without area, loose vertices, edges of
    three and more faces and open surfaces are measured as what they are.
    Raises ValueError (array, a corner that is no vertex), SinewError (no vertices).
    """

    def __new__(cls, points: NDArray[np.float32], triangles: NDArray[np.int32]) -> RestSurface: ...
    @property
    def rest_hits(self) -> int:
        """Pairs of triangles that cut each other at rest and share no vertex."""
    def region(
        self, centre: Sequence[float], radius: float, carried: NDArray[np.bool_] | None = None
    ) -> SurfaceRegion | None:
        """The skin around a joint: of the triangles whose rest middle is nearer to `centre` than `radius` (m), and that
        have one of the `carried` vertices ((V,) bool; None: all), the largest part that hangs together; None where there
        is no such triangle."""
    def whole(self) -> SurfaceRegion:
        """All of the surface as one region."""
    def deformed(self, points: NDArray[np.float32]) -> DeformedSurface:
        """A deformed state: (V, 3) float32, m, in the same space and order as the rest points."""

@final
class SurfaceRegion:
    """A part of a surface to be measured by itself; len() is its number of triangles."""

    def __len__(self) -> int: ...
    @property
    def faces(self) -> NDArray[np.int32]:
        """Its triangles, as places in the surface's list, rising."""
    @property
    def rest_union(self) -> float:
        """Volume that it occupies at rest, m^3, closed by a fan from the middle of each of its rims."""

@final
class DeformedSurface:
    """One deformed state of a surface."""

    def quality(self, region: SurfaceRegion) -> SkinQuality:
        """The quality of a region of the same surface. Raises ValueError for a region of another surface."""
    @property
    def inverted(self) -> NDArray[np.bool_]:
        """(F,) whether each triangle points against the skin around it: its normal against its rest normal, turned by the
        rigid fit of the three rings of vertices around its corners."""
    @property
    def new_hits(self) -> NDArray[np.int32]:
        """(N, 2) pairs of triangles that cut each other, share no vertex and did not cut each other at rest."""
    @property
    def vertex_stretch(self) -> NDArray[np.float32]:
        """(V,) length over rest length of that edge at each vertex which changed most; 1 at a loose vertex."""

@final
class SkinQuality:
    """The quality of one region in one deformed state. Ratios are over rest: 1 is as at rest. A region that is flat at
    rest has no volumes to compare: they are 1, overlap and inside_out 0."""

    @property
    def union(self) -> float:
        """Volume really occupied, by winding number along 200 x 200 rays in z, the region closed over its rims."""
    @property
    def overlap(self) -> float:
        """Volume occupied once too often, over the volume occupied at rest."""
    @property
    def inside_out(self) -> float:
        """Volume turned inside out, over the volume occupied at rest."""
    @property
    def unreadable(self) -> float:
        """Share 0..1 of the rays whose crossings do not cancel, as through a hole; they are left out."""
    @property
    def volume(self) -> float:
        """Signed volume; counts folds twice, and so flatters a skin that folds."""
    @property
    def edge_p50(self) -> float:
        """Median over the edges of max(l / l0, l0 / l)."""
    @property
    def edge_p99(self) -> float:
        """What 99 of 100 edges do not exceed."""
    @property
    def edge_max(self) -> float:
        """The worst edge."""
    @property
    def area_p99(self) -> float:
        """What 99 of 100 triangles do not exceed of max(A / A0, A0 / A)."""
    @property
    def inverted(self) -> int:
        """Inverted triangles, see `DeformedSurface.inverted`."""
    @property
    def new_hits(self) -> int:
        """New self-hits of which at least one triangle lies in the region."""
    @property
    def bend_p99(self) -> float:
        """What 99 of 100 edges do not exceed of the change of the angle between their two faces, degrees 0..180."""

@final
class KeptSamples:
    """Few samples of a moving skin whose cross-fade stays near all of them (ALGORITHM 11).

    Distances are those on the posed skin, mesh space: what the Armature modifier makes of a difference between corrections.

    poses: (K, B, 4, 4) float32, column-major, as `Skin.correct` takes them. corrections: (K, V, 3) float32, m, in those poses. at:
    (K,) float64, rising, such as frames. tolerances: (K,) float64, m, how far what is shown may be from each. candidates: (K,) bool, which samples may be kept; the others are checked all the same.
    Each straight line goes as far as it may before the next sample is kept; what was kept before, or nothing, is shown again
    where it is near enough.
    Raises ValueError (array), SinewError (`at` does not rise, a negative tolerance).
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
        """The samples at which one shape alone is shown; between two of them both cross-fade, outside the nearest stays."""
    @property
    def shown(self) -> list[int | None]:
        """The sample whose corrections are shown at each place; None: no correction."""
    @property
    def errors(self) -> NDArray[np.float64]:
        """(K,) largest distance of each sample from what is shown there, m."""

@final
class MotionKeys:
    """The corrective keys that one motion of a joint needs (ALGORITHM 11): its samples from rest outward, each as far from the
    one before as the tolerance allows.

    A key's hat is 1 at its own value and falls linearly to 0 at its neighbours and at rest, 0; the outermost stay 1 beyond.

    poses: (K, B, 4, 4) float32, column-major. corrections: (K, V, 3) float32, m, in those poses. at: (K,) float64, rising, 0 (rest)
    among them. Distances are those on the posed skin, as of `KeptSamples`. tolerance: m, how far what is shown may be
    from any sample. threshold: m, entries up to this long become 0.
    Raises ValueError (array), SinewError (`at` does not rise or lacks 0).
    """

    def __new__(
        cls,
        skin: Skin,
        poses: NDArray[np.float32],
        corrections: NDArray[np.float32],
        at: NDArray[np.float64],
        tolerance: float,
        threshold: float,
    ) -> MotionKeys: ...
    def __len__(self) -> int: ...
    @property
    def at(self) -> list[float]:
        """The value of each key, rising; never 0."""
    def correction(self, key: int) -> NDArray[np.float32]:
        """(V, 3) what a key adds at its value, m. Raises ValueError where there is no such key."""
    @property
    def error_at(self) -> float:
        """Largest distance from the samples that are keys, m."""
    @property
    def error_between(self) -> float:
        """Largest distance from all other samples, m."""

@final
class CombinationKeys:
    """The corrective keys that two motions at once need beyond their own, in one of the four quadrants around rest (ALGORITHM 11).

    A key acts by the product of two hats. They stand at first on the outermost values alone, then on one more at a time, where it
    lowers the largest error most, while that is above the tolerance. Rest, 0, is where every hat ends.

    first, second: of the same mesh. first_at (F,), second_at (G,): float64, rising, of one sign each; hats may stand on the outermost
    and on every second one from there inward, those between are checked. poses: (F, G, B, 4, 4) float32, column-major. corrections:
    (F, G, V, 3) float32, m. tolerance, threshold: m. most: keys at most.
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
        """The values of the first motion that hats stand on, rising; rest besides."""
    @property
    def second_at(self) -> list[float]:
        """The same of the second motion."""
    @property
    def corners(self) -> list[tuple[int, int]]:
        """Each key's place in `first_at` and in `second_at`."""
    def correction(self, key: int) -> NDArray[np.float32]:
        """(V, 3) what a key adds where both hats are 1, m. Raises ValueError where there is no such key."""
    @property
    def error_before(self) -> float:
        """Largest distance of all samples from the motions' own keys alone, m."""
    @property
    def error_at(self) -> float:
        """Largest distance of the samples where both hats are 1, m."""
    @property
    def error_between(self) -> float:
        """Largest distance of all other samples, m."""

@final
class SkinMotion:
    """Jitter and pop of a skin over a sequence of poses at equal small steps, beside linear skinning of the same poses.

    frames, reference: (N, V, 3) float32, m. counted: (V,) bool, which vertices count; None: all.
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
        """The same of the reference."""
    @property
    def jitter_excess_p99(self) -> float:
        """The same of the difference between both."""
    @property
    def pop_max(self) -> float:
        """Farthest that any vertex moves from one frame to the next, m."""
    @property
    def pop_reference_max(self) -> float:
        """The same of the reference."""
    @property
    def pop_excess(self) -> float:
        """Farthest that any vertex moves from one frame to the next against its reference, m."""
    @property
    def pop_frame(self) -> int:
        """Where that is: from this frame to the next."""
    @property
    def pop_vertex(self) -> int:
        """The vertex that does."""
    @property
    def pop_persistence(self) -> float:
        """The excess over one frame as a share of that over two: about a half where movement is continuous, near 1 at a
        jump."""

@final
class PolygonMesh:
    """The polygons of a mesh, in metres of the space that they are used in.

    points: (V, 3) float32, mesh space. corners: (C,) int32, the vertex of each corner, polygon after polygon. face_offsets:
    (F + 1,) int32, where the corners of each polygon start, then C; a polygon has 3 or more. to_space: (4, 4) float32,
    column-major, from mesh space to the space that it is used in; None for the same. `len` is F.
    A polygon of more than 3 corners is a fan of triangles around the mean of its corners, and so the same on the left and on
    the right of a symmetric body.
    Raises ValueError (array, offsets, a corner that is no vertex), SinewError (a matrix that is not affine).
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
    """Tissues as they are placed on a body: ellipsoids with tendons and via points, armature space, before or after a fit.

    kinds: one a tissue. centres: (T, 3) float64, m. rotations: (T, 4) float64, quaternions (w, x, y, z); local z runs from
    origin to insertion. semi_axes: (T, 3) float64, m, > 0. tendons: (T, 2) float64, m, >= 0: at the origin and at the
    insertion. via_offsets: (T + 1,) int32, where the via points of each tissue start, then P. via_points: (P, 3) float64, m.
    The properties are new arrays of these shapes. `len` is T.
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
    """The skin of one mesh or several at rest, all in one space, seen as one surface that is asked where its skin is.

    Meshes may overlap. The normals of each must agree with each other, and may all look inward. A ray that starts inside a
    limb first meets that limb's own skin, however near the torso is. What is found depends neither on the order of meshes and
    faces nor on the number of threads.
    Raises SinewError (a mesh without faces, no mesh).
    """

    def __new__(cls, meshes: Sequence[PolygonMesh]) -> SkinSurface: ...
    @property
    def size(self) -> float:
        """The longest side of the box around the skin, m."""
    @property
    def margin(self) -> float:
        """How far under the skin a fitted belly ends, m: 1-2 mm on a person."""
    def distances_along(
        self, origins: NDArray[np.float64], directions: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """(N,) float64: how far the skin is, in lengths of each direction; 0 from a point that is outside already, NaN where
        there is no skin that way.

        origins: (N, 3) float64, m. directions: (N, 3) float64, of any length.
        """
    def are_inside(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """(N,) bool: whether the skin encloses each of (N, 3) float64 points, m. Most of three rays decide, so a hole does no
        harm; of closed meshes it is where the winding number is above 0.
        """
    def nearest(self, points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(N, 3) float64: the points of the skin nearest to (N, 3) float64 points, m, from either side; and (N,) float64: how
        far away, m.
        """
    def fit(self, tissues: PlacedTissues, lefts: NDArray[np.int32]) -> PlacedTissues:
        """Each tissue with the widths that its place under the skin allows; as it is where the skin does not cover it.

        lefts: (T,) int32, for each tissue the one on the left whose mirror image across x = 0 it may be, -1 for none. It is
        exactly that image where both were placed as images and the skin is as far from both.
        Raises ValueError (array, a left that is no tissue).
        """
    def protrusions(self, tissues: PlacedTissues) -> NDArray[np.float64]:
        """(T,) float64: how far each tissue pokes out of the skin, m; 0 where it does not."""

@final
class SurfaceTransfer:
    """What a new surface takes over from an old one in its place: for each new vertex the nearest point of the old surface.

    former, made: in one space. near: m, how far away the old surface may be for a vertex to take something from it.
    C is the number of corners of the old surface, N that of vertices and G that of faces of the new one.
    Raises SinewError (`former` has no faces, a negative `near`).
    """

    def __new__(cls, former: PolygonMesh, made: PolygonMesh, near: float) -> SurfaceTransfer: ...
    @property
    def is_near(self) -> NDArray[np.bool_]:
        """(N,) bool: whether the old surface is near."""
    @property
    def nearest_faces(self) -> NDArray[np.int32]:
        """(G,) int32: the old face that is nearest to the middle of each new one."""
    @property
    def nearest_corners(self) -> NDArray[np.int32]:
        """(N,) int32: that corner of the nearest old face, among all corners, of which a vertex has most."""
    def mixed(self, values: NDArray[np.float32]) -> NDArray[np.float32]:
        """(N, W) float32: values of the old surface's corners, (C, W) float32, mixed for each new vertex by barycentric
        coordinates in the fan of its nearest face; 0 where the old surface is not near.
        """

@final
class Path:
    """A polyline with its arc length. points: (N, 3) float64, m, at least one."""

    def __new__(cls, points: NDArray[np.float64]) -> Path: ...
    @property
    def length(self) -> float:
        """Arc length, m."""
    def at(self, length: float) -> tuple[float, float, float]:
        """The point at that arc length, m; beyond its ends the path goes on straight."""
    def nearest_length(self, point: Sequence[float]) -> float:
        """The arc length, m, at which the path is nearest to a point; of several the first."""

def nearest_on_segment(
    point: Sequence[float], start: Sequence[float], end: Sequence[float]
) -> tuple[tuple[float, float, float], float]:
    """The point of a segment nearest to a point, m, and how far along the segment it is, 0 to 1. (3,) each."""

@final
class Progress:
    """How far a long computation is, and a way to end it, from another thread."""

    def __new__(cls) -> Progress: ...
    @property
    def done(self) -> float:
        """The part done, 0..1."""
    def cancel(self) -> None:
        """Ends the computation soon, with a SinewError; one that is to begin with this ends at once."""

@final
class GrownSkin:
    """A skin grown over all tissues in the rest pose (ALGORITHM 7; Wilhelms 1997).

    musculature: the tissues, T of them, on B bones.
    skin_thickness: (T,) float32, m, >= 0: of the skin over each tissue, added to `thickness`.
    bone_lengths: (B,) float32, m, along each bone's y axis. stand_ins: (B,) int32: for each bone the one whose weight it
    counts for: itself, or where it deforms no mesh the next one above that does.
    resolution: voxels along the longest side, 4..8192. thickness: m.
    smoothing, radius, decay: passes (0..100) of a filter that looks `radius` (0..4) voxels far with the weights
    e^(-decay d^2), d in voxels; each voxel keeps its original depth where that is more.
    faces: the most faces; None for as many as the resolution gives.
    symmetric: exactly symmetric about x = 0 wherever the tissues are, but for rounding.
    largest_only: drop all pieces but the largest.
    memory_limit_mb: more is refused, with the number it would take, before it is taken.
    progress: to be asked and cancelled from another thread.
    The surface is a closed manifold of quads, whatever the tissues are; depends on nothing but the arguments, bit for bit.
    Raises ValueError (array), SinewError (a value outside its limits, no tissues, memory, cancelled).
    """

    def __new__(
        cls,
        musculature: Musculature,
        skin_thickness: NDArray[np.float32],
        bone_lengths: NDArray[np.float32],
        stand_ins: NDArray[np.int32],
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
        """(V + 1,) where the weights of each vertex start, as `Skin` takes them; at most 4 a vertex, which sum to 1."""
    @property
    def weight_bones(self) -> NDArray[np.int32]:
        """(W,) the bone of each weight."""
    @property
    def weights(self) -> NDArray[np.float32]:
        """(W,) the weights, each vertex's heaviest first."""
    @property
    def voxel(self) -> float:
        """Edge of a voxel of the lattice that the faces stand on, m."""
    @property
    def thickened(self) -> list[str]:
        """Names of tissues that were thinner than a voxel, stood out of the others, and were thickened to be kept."""
    @property
    def pieces(self) -> int:
        """Pieces that do not hang together, before any was dropped."""
    @property
    def worst_quality(self) -> float:
        """Shape of the worst face: 4 sqrt(3) area over the squared edges of the worse triangle of a quad, cut along its better
        diagonal; 1 is equilateral. Not below 0.1."""
    @property
    def protrusion(self) -> float:
        """How far a point of the anatomy stands out of the skin at most, m (100 points on each ellipsoid)."""
    @property
    def protruding(self) -> str | None:
        """The tissue that does."""

def nearest_on_ellipsoid(
    semi_axes: Sequence[float], points: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Nearest points on the surface of an ellipsoid at the origin, axes along x, y, z (Eberly; ALGORITHM 3).

    points: (N, 3) float64, C order; any place: inside, on an axis, at the centre (then the end of the shortest axis).
    Returns (N, 3) float64.
    """

@final
class Linkage:
    """Joints that hang on each other as a tree, from the body outward, for `reach` (ALGORITHM 10).

    Space here is the armature's, metres and radians, float64; matrices are column-major as everywhere.

    names: one a joint, unique. parents: (J,) int32, an earlier joint, -1 for one that hangs on nothing that moves.
    sockets: (J, 4, 4) where each bone stands at angles of 0, in the axes of the parent's posed bone (armature space without
    a parent). A bone lies along its y.
    freedoms: what a joint's three angles mean:
      - BALL: a rotation vector; no singular pose within a full turn, so for joints without limits.
      - SWING_TWIST: x and z are the rotation vector of a swing, after a twist y about the bone: Blender's IK limits.
      - XYZ and the other orders: Euler angles as Blender's, the first axis turns first.
    angles, lower, upper: (J, 3) rad; finite (a large number for no limit). Equal limits lock an angle; angles outside their
    limits are brought to the nearest.
    scales: (J, 3) of the bone along its own axes, after its rotation. multipliers: (J,) 0.1..2.5, how eager a joint is.
    turns_with_parent: False: it moves with its parent's bone, but does not turn; its socket's linear part is then in
    armature space.
    Raises ValueError (array), SinewError naming the joint.
    """

    def __new__(
        cls,
        names: Sequence[str],
        parents: NDArray[np.int32],
        sockets: NDArray[np.float64],
        freedoms: Sequence[Freedoms],
        angles: NDArray[np.float64],
        lower: NDArray[np.float64],
        upper: NDArray[np.float64],
        *,
        scales: NDArray[np.float64] | None = None,
        multipliers: NDArray[np.float64] | None = None,
        turns_with_parent: Sequence[bool] | None = None,
    ) -> Linkage: ...
    def __len__(self) -> int: ...
    @property
    def freedom_count(self) -> int:
        """Number of angles that are not locked."""
    @property
    def angles(self) -> NDArray[np.float64]:
        """(J, 3) the angles it was made with, within their limits."""
    def heads(self, angles: NDArray[np.float64]) -> NDArray[np.float64]:
        """(J, 3) where the joints are at some angles (J, 3), armature space."""

@final
class Goal:
    """What is wished of the bone of one joint.

    kind and target:
      - POSITION: `point` shall be at target, (3,) armature space.
      - ORIENTATION: the bone's axes shall have the rotation target, a quaternion (w, x, y, z), armature space.
      - LOOK_AT: `axis` of the bone, from `point` on, shall point at target, (3,) armature space.
    point: (3,) m in the axes of the posed bone, from its head (with its scale). axis: (3,) in the same axes, y if None.
    weight: >= 0; a miss of the linkage's whole length counts as much as one of 1 rad.
    Raises ValueError; what does not fit a linkage is told by `reach`.
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
    """A pose that was found."""

    @property
    def angles(self) -> NDArray[np.float64]:
        """(J, 3) rad, within the limits to the last bit."""
    @property
    def misses(self) -> list[float]:
        """How far each goal is missed: m for a position, rad for the others."""
    @property
    def evaluations(self) -> int:
        """How often the cost was computed."""

def reach(
    linkage: Linkage,
    goals: Sequence[Goal],
    preferred: NDArray[np.float64] | None = None,
    *,
    preference: float = 1e-3,
    restarts: int = 0,
) -> Reached:
    """The pose that meets the goals best, from the linkage's own pose on (Zhao and Badler 1994; ALGORITHM 10).

    preferred: (J, 3) the pose that is kept to where the goals leave a choice; the linkage's own if None. preference: how much
    it counts. restarts: from how many other poses to try again where goals are missed; 0 while dragging, so that nothing
    jumps. The same arguments give the same bits. Raises ValueError, SinewError.
    """

def reach_clip(
    linkages: Sequence[Linkage],
    goals: Sequence[Sequence[Goal]],
    *,
    preference: float = 1e-3,
    restarts: int = 0,
    smoothness: float = 0.01,
) -> list[Reached]:
    """The poses of consecutive frames, one linkage and its goals a frame, of the same joints with the same locks.

    What each frame prefers is its linkage's own pose. smoothness: how much the squared second differences of the angles count
    against the goals; 0: each frame as it follows from the one before. Raises ValueError, SinewError.
    """

def joint_rotation(freedoms: Freedoms, angles: Sequence[float]) -> tuple[float, float, float, float]:
    """The rotation (w, x, y, z) of a joint at some angles."""

def joint_angles(
    freedoms: Freedoms, rotation: Sequence[float], near: Sequence[float]
) -> tuple[float, float, float]:
    """The angles that give a rotation (w, x, y, z): of all that do, those nearest to `near`."""

def set_thread_count(count: int) -> None:
    """Threads of the pool that deforms, 0 for one a core; results are the same bits for any number. Raises ValueError."""
