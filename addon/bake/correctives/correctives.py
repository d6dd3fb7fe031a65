# SPDX-License-Identifier: GPL-3.0-or-later
"""Correctives: shape keys that the joints' angles blend, so that a skin moves without Sinew as with it (ALGORITHM 11).

A key holds basis + what the live correction adds at its pose beyond the other keys that act there, before the Armature modifier.
Each joint is sampled by itself through its whole range; where two joints together need more than each alone, keys for both
follow. Errors are distances on the posed skin, in the world. A muscle's tension is taken as 0.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import combinations, pairwise

import bpy
import _sinew
import numpy as np

from ...errors import SinewError
from ...live import session
from ...measure import joint_regions
from ...reach import bone_limits
from ...scene import armature_modifier, bone_geometry, live_switch, mesh_arrays
from ..keys import key_store
from ..scratch import joint_turns
from ..scratch.joint_turns import Motion
from ..scratch.pose_sampler import PoseSampler
from . import corrective_drivers

# between two samples of a motion, at first and where the skin needs closer ones
STEP_RAD, FINEST_RAD = math.radians(5.0), math.radians(0.3)
# two motions together: values on each axis, of which every second may become a key's, up to a share of what each does alone: at
# both ends limbs are inside each other
GRID, SHARE_TOGETHER = 6, 2.0 / 3.0
FARTHEST_SWING = 0.9  # squared sine of half of it
# where keys are too many, the tolerance is raised by this until they are not
LOOSENED = 1.1
_TRIED_RAD = math.radians(45.0)
# what the progress bar gives to the joints by themselves
_ALONE = 0.5
LONGEST_NAME = 63
ERRORS = ("error_at_mm", "error_between_mm", "error_before_mm")


@dataclass(frozen=True)
class Settings:
    """What is baked.

    joints: bones whose heads they are; None: all that muscles cross. all_joints: instead all with a correction above the
    tolerance. angles: as `joint_turns.parse`, of each joint, or of all; empty: from limits. tolerance_mm: in the world. threshold_mm:
    shorter entries of a key become 0. most_alone: keys at most of each motion, which goes before the tolerance; 0: as many as
    that needs. most_together: keys at most of each pair of motions, for each of the four ways in which both can turn.
    """

    joints: list[str] | None
    all_joints: bool
    angles: list[str]
    twists: bool
    tolerance_mm: float
    threshold_mm: float
    most_alone: int
    most_together: int
    prefix: str


@dataclass
class JointResult:
    """What one mesh needs for one motion, or two: keys, and the errors in mm, with the worst between its keys."""

    turns: list[Motion]
    keys: int
    error_at_mm: float
    error_between_mm: float
    error_before_mm: float = 0.0


@dataclass(frozen=True)
class _Sample:
    """The corrections of all meshes in one pose, and that pose as the core takes it."""

    corrections: list[np.ndarray]
    pose: np.ndarray


@dataclass
class _SkinKeys:
    """The keys of one mesh, to be written at the end."""

    name: str
    per_metre: float  # mm in the world for a metre in the mesh
    alone: dict[Motion, "_sinew.MotionKeys"] = field(default_factory=dict)
    regions: dict[Motion, np.ndarray] = field(default_factory=dict)
    together: list[tuple[Motion, Motion, "_sinew.CombinationKeys"]] = field(default_factory=list)


class CorrectiveBake:
    """A bake of the correctives of some skins of one rig. Run through `steps`, or `cancel`led: then nothing has changed."""

    def __init__(self, rig, skins: list, scene, settings: Settings):
        key_store.check_bakeable(skins, settings.prefix)
        _check(rig, skins, settings)
        self.rig, self._scene, self.settings = rig.name, scene, settings
        self._skins = [_SkinKeys(skin.name, key_store.mm_per_metre(skin)) for skin in skins]
        self._sampler = PoseSampler(rig, skins)
        try:
            for skin in skins:
                if skin.sinew.live and session.reason(skin):
                    raise SinewError(session.reason(skin))
            self.motions = self._motions(rig, skins)
        except Exception:
            self._sampler.remove()
            raise
        self.found: dict[str, list[JointResult]] = {skin.name: [] for skin in skins}
        self.silenced = 0

    def steps(self) -> Iterator[float]:
        """Bakes, a pose at a step, yielding the part done, 0..1. Raises SinewError."""
        for done, motion in enumerate(self.motions):
            for part in self._sample_alone(motion):
                yield _ALONE * (done + part) / len(self.motions)
        pairs = [pair for pair in combinations(self.motions, 2) if self._may_need_more(*pair)]
        for done, pair in enumerate(pairs):
            for part in self._sample_together(*pair):
                yield _ALONE + (1.0 - _ALONE) * (done + part) / len(pairs)
        self._sampler.remove()
        rig = bpy.data.objects.get(self.rig)
        skins = [bpy.data.objects.get(keys.name) for keys in self._skins]
        if rig is None or None in skins:
            raise SinewError("the armature or one of its meshes was renamed or deleted meanwhile: bake again")
        for skin, keys in zip(skins, self._skins, strict=True):
            self._write(rig, skin, keys)
            skin.sinew.live = False
            live_switch.show_live(skin)
            skin.sinew.corrective_summary = "\n".join(summary_of(self.found[keys.name]))
        yield 1.0

    def cancel(self):
        """Leaves all as it was; once written, there is nothing left to cancel."""
        self._sampler.remove()

    def _motions(self, rig, skins: list) -> list[Motion]:
        """All motions of all joints, each joint once, whichever of the meshes it moves."""
        asked = self.settings.joints
        if self.settings.all_joints:
            asked = [bone.name for bone in rig.data.bones if bone.use_deform and bone.parent]
        found: dict[str, joint_regions.Joint] = {}
        for skin in skins:
            for joint in joint_regions.joints_of(skin, rig, self._sampler.rest, self._sampler.musculature, asked, "MUSCLES"):
                found.setdefault(joint.bone, joint)
        if not self.settings.joints:
            # what follows other bones by constraints is no joint of its own, but where nothing else is
            free = found.keys() - bone_limits.driven_bones(rig)
            found = {bone: joint for bone, joint in found.items() if bone in free or not free}
        self._sampler.pose_for(self._scene, rig, list(found))
        if self.settings.all_joints:
            found = {bone: joint for bone, joint in found.items() if self._has_effect(rig, joint)}
        if not found:
            raise SinewError(f"{rig.name} has no joint with a correction to bake: name bones, or choose Selected Bones")
        told = self.settings.angles or [""]
        if len(told) not in (1, len(found)):
            raise SinewError(
                f"there are {len(told)} ranges of angles for {len(found)} joints: give one for all, or one for each"
            )
        told = told * len(found) if len(told) == 1 else told
        every = [
            motion
            for joint, text in zip(found.values(), told, strict=True)
            for motion in joint_turns.motions_of(rig, joint, text, self.settings.twists)
        ]
        if not every:
            raise SinewError(f"{', '.join(found)}: locked on all axes, nothing turns")
        return every

    def _has_effect(self, rig, joint: joint_regions.Joint) -> bool:
        tried = joint_turns.motions_of(rig, joint, "", self.settings.twists)
        return any(
            self._longest_mm(place, correction) > self.settings.tolerance_mm
            for motion in tried
            for end in (motion.low, motion.high)
            for place, correction in enumerate(self._sampler.corrections([(motion, max(min(end, _TRIED_RAD), -_TRIED_RAD))]))
        )

    def _longest_mm(self, place: int, correction: np.ndarray) -> float:
        return self._skins[place].per_metre * float(np.linalg.norm(correction, axis=1).max(initial=0.0))

    def _sample_alone(self, motion: Motion) -> Iterator[float]:
        """Samples a motion, closer where straight lines between samples miss it, and keeps the keys that it needs."""
        values = [*_values(motion.low)[::-1], 0.0, *_values(motion.high)]
        samples: dict[float, _Sample] = {}
        for value in values:
            samples[value] = self._sampled((motion, value))
        for correction in samples[0.0].corrections:
            correction[:] = 0.0  # at rest nothing is added
        jumps_mm = [0.0] * len(self._skins)
        for number, (low, high) in enumerate(pairwise(values)):
            self._refine(motion, samples, low, high, jumps_mm)
            yield (number + 1) / (len(values) - 1)
        values = sorted(samples)
        poses = np.array([samples[value].pose for value in values])
        for place, keys in enumerate(self._skins):
            corrections = np.array([samples[value].corrections[place] for value in values])
            made = self._keys_of_motion(place, keys, poses, corrections, np.array(values))
            keys.alone[motion] = made
            region = np.zeros(len(corrections[0]), bool)
            for key in range(len(made)):
                region |= made.correction(key).any(axis=1)
            keys.regions[motion] = region
            between_mm = max(keys.per_metre * made.error_between, jumps_mm[place])
            self.found[keys.name].append(JointResult([motion], len(made), keys.per_metre * made.error_at, between_mm))

    def _sampled(self, *turns: tuple[Motion, float]) -> "_Sample":
        return _Sample(self._sampler.corrections(list(turns)), self._sampler.pose.copy())

    def _refine(self, motion: Motion, samples: dict, low: float, high: float, jumps_mm: list[float]):
        """Samples between two samples, and on both sides of that again, while the straight line misses the skin there."""
        middle = 0.5 * (low + high)
        samples[middle] = self._sampled((motion, middle))
        three = [samples[value] for value in (low, middle, high)]
        misses_mm = [self._miss_of_line_mm(place, keys, three) for place, keys in enumerate(self._skins)]
        # a parabola that is missed by this much in the middle is missed by a quarter of it between the three
        if max(misses_mm) <= 0.5 * self.settings.tolerance_mm:
            return
        if high - low > 2.0 * FINEST_RAD:
            self._refine(motion, samples, low, middle, jumps_mm)
            self._refine(motion, samples, middle, high, jumps_mm)
        else:
            # the live skin jumps, as where skin meets skin: nothing between can be told any better
            jumps_mm[:] = map(max, jumps_mm, misses_mm)

    def _miss_of_line_mm(self, place: int, keys: _SkinKeys, three: list["_Sample"]) -> float:
        """How far the middle one of three samples is from the line between the others, on the posed skin."""
        poses = np.array([sample.pose for sample in three])
        corrections = np.array([sample.corrections[place] for sample in three])
        ends, at = np.array([True, False, True]), np.arange(3.0)
        line = _sinew.KeptSamples(self._sampler.skin(place), poses, corrections, at, np.zeros(3), ends)
        return keys.per_metre * float(line.errors[1])

    def _keys_of_motion(self, place: int, keys: _SkinKeys, poses, samples, values) -> "_sinew.MotionKeys":
        """The keys that the tolerance asks for, or the fewer that are allowed, with the least error that they can have."""
        tolerance, threshold = self._lengths(keys)
        while True:
            made = _sinew.MotionKeys(self._sampler.skin(place), poses, samples, values, tolerance, threshold)
            if len(made) <= (self.settings.most_alone or len(made)):
                return made
            tolerance *= LOOSENED

    def _may_need_more(self, first: Motion, second: Motion) -> bool:
        """Whether two bends are of one joint, or of two with none between them, and move any vertex both."""
        if not self.settings.most_together or first.is_twist or second.is_twist:
            return False
        bones, joints = bpy.data.objects[self.rig].data.bones, {motion.bone for motion in self.motions}
        above = [
            next((bone.name for bone in bones[motion.bone].parent_recursive if bone.name in joints), "")
            for motion in (first, second)
        ]
        if first.bone != second.bone and above[0] != second.bone and above[1] != first.bone:
            return False
        return any((keys.regions[first] & keys.regions[second]).any() for keys in self._skins)

    def _sample_together(self, first: Motion, second: Motion) -> Iterator[float]:
        """Samples two motions at once in each quadrant around rest, and keeps the keys that they need beyond their own."""
        quadrants = [(a, b) for a in (first.low, first.high) for b in (second.low, second.high) if a and b]
        for done, (first_end, second_end) in enumerate(quadrants):
            first_end, second_end = _together(first, first_end, second, second_end)
            if any(self._miss(first, share * first_end, second, share * second_end) for share in (1.0, 0.5)):
                values = [np.sort(end * np.arange(1, GRID + 1) / GRID) for end in (first_end, second_end)]
                poses, samples = self._empty(GRID, GRID)
                for row, first_value in enumerate(values[0]):
                    for column, second_value in enumerate(values[1]):
                        self._sample(poses, samples, (row, column), (first, first_value), (second, second_value))
                    yield (done + (row + 1) / GRID) / len(quadrants)
                found = self._combined(first, second, *values, poses, samples, self.settings.most_together)
                for keys, own in zip(self._skins, found, strict=True):
                    self._keep_together(keys, first, second, own)
            yield (done + 1) / len(quadrants)

    def _miss(self, first: Motion, first_value: float, second: Motion, second_value: float) -> bool:
        """Whether the motions' own keys miss the tolerance where both turn."""
        poses, samples = self._empty(1, 1)
        self._sample(poses, samples, (0, 0), (first, first_value), (second, second_value))
        found = self._combined(first, second, np.array([first_value]), np.array([second_value]), poses, samples, 0)
        return any(
            keys.per_metre * own.error_before > self.settings.tolerance_mm
            for keys, own in zip(self._skins, found, strict=True)
        )

    def _empty(self, *counts: int) -> tuple[np.ndarray, list[np.ndarray]]:
        """Room for the poses of samples, and for the corrections of each skin in them."""
        vertices = [len(self._sampler.points(place)) for place in range(len(self._skins))]
        poses = np.empty((*counts, *self._sampler.pose.shape), np.float32)
        return poses, [np.empty((*counts, count, 3), np.float32) for count in vertices]

    def _sample(self, poses: np.ndarray, samples: list[np.ndarray], place, *turns: tuple[Motion, float]):
        for own, correction in zip(samples, self._sampler.corrections(list(turns)), strict=True):
            own[place] = correction
        poses[place] = self._sampler.pose

    def _combined(
        self, first: Motion, second: Motion, first_at, second_at, poses, samples, most: int
    ) -> list["_sinew.CombinationKeys"]:
        return [
            _sinew.CombinationKeys(
                self._sampler.skin(place),
                keys.alone[first],
                keys.alone[second],
                first_at,
                second_at,
                poses,
                own,
                *self._lengths(keys),
                most,
            )
            for place, (keys, own) in enumerate(zip(self._skins, samples, strict=True))
        ]

    def _keep_together(self, keys: _SkinKeys, first: Motion, second: Motion, made: "_sinew.CombinationKeys"):
        errors = (keys.per_metre * error for error in (made.error_at, made.error_between, made.error_before))
        self.found[keys.name].append(JointResult([first, second], len(made), *errors))
        if len(made):
            keys.together.append((first, second, made))

    def _lengths(self, keys: _SkinKeys) -> tuple[float, float]:
        """Tolerance and threshold in the mesh's own lengths."""
        return self.settings.tolerance_mm / keys.per_metre, self.settings.threshold_mm / keys.per_metre

    def _write(self, rig, skin, keys: _SkinKeys):
        """Swaps the new keys in for the earlier correctives of these joints."""
        joints = {motion.bone for motion in self.motions}
        for baked in [baked.name for baked in skin.sinew.baked_keys if joints & set(baked.joints.split("\n"))]:
            key_store.remove_key(skin, baked)
        points = mesh_arrays.read_points(skin.data)
        active = skin.active_shape_key_index
        for motion, made in keys.alone.items():
            for place, value in enumerate(made.at):
                tents = [corrective_drivers.tent_at(motion, made.at, place)]
                self._add(rig, skin, motion.label(value), points + made.correction(place), tents)
        for first, second, made in keys.together:
            for place, (row, column) in enumerate(made.corners):
                label = f"{first.label(made.first_at[row])} {second.label(made.second_at[column])}"
                tents = [
                    corrective_drivers.tent_at(first, made.first_at, row),
                    corrective_drivers.tent_at(second, made.second_at, column),
                ]
                self._add(rig, skin, label, points + made.correction(place), tents)
        skin.active_shape_key_index = active
        for baked in skin.sinew.baked_keys:
            # keys of frames would add up with these; correctives that a bake of frames silenced act again
            self.silenced += not baked.joints and not baked.silenced
            baked.silenced = not baked.joints

    def _add(self, rig, skin, label: str, points: np.ndarray, tents: list[corrective_drivers.TentWeight]):
        name = self.settings.prefix + label
        key = key_store.add_key(skin, name.encode()[:LONGEST_NAME].decode(errors="ignore"), points)
        corrective_drivers.drive(key, rig, tents)
        baked = skin.sinew.baked_keys.add()
        baked.name, baked.joints = key.name, "\n".join(tent.motion.bone for tent in tents)
        baked.pose = joint_turns.text_of([(tent.motion, tent.peak) for tent in tents])


def summary_of(found: list[JointResult]) -> list[str]:
    """A line for each joint, and one for each pair of joints that needed keys of its own."""
    lines = []
    groups: dict[tuple[str, bool], list[JointResult]] = {}
    for one in found:
        bones = " with ".join(dict.fromkeys(motion.bone for motion in one.turns))
        groups.setdefault((bones, len(one.turns) > 1), []).append(one)
    for (bones, together), of_bones in sorted(groups.items(), key=lambda group: group[0][1]):
        keys = sum(one.keys for one in of_bones)
        at, between, before = (max(getattr(one, name) for one in of_bones) for name in ERRORS)
        what = f"{bones}{' (about two axes)' if together and ' with ' not in bones else ''}"
        without = f" ({before:.1f} without)" if together else ""
        lines.append(f"{what}: {keys} keys, {at:.4f} mm at them, {between:.2f} mm between{without}")
    return lines


def _together(first: Motion, first_end: float, second: Motion, second_end: float) -> tuple[float, float]:
    """How far two motions go together, of how far each goes alone: two swings of one bone add up, and less than half a turn."""
    share = SHARE_TOGETHER
    while (
        first.bone == second.bone
        and sum(math.sin(0.5 * share * end) ** 2 for end in (first_end, second_end)) > FARTHEST_SWING
    ):
        share *= 0.9
    return share * first_end, share * second_end


def _values(end: float) -> list[float]:
    """The values from rest to an end, that included, rest not."""
    count = math.ceil(abs(end) / STEP_RAD - 1e-6)
    return [end * (step + 1) / count for step in range(count)]


def _check(rig, skins: list, settings: Settings):
    if rig.mode == "EDIT":
        raise SinewError(f"{rig.name} is in Edit Mode: leave it (Tab) and bake again")
    if rig.data.pose_position == "REST":
        raise SinewError(f"{rig.name} shows its rest pose: leave Edit Rest Pose and bake again")
    for bone in settings.joints or ():
        if not bone_geometry.has_bone(rig, bone):
            raise SinewError(f"{rig.name} has no bone '{bone}'")
    for skin in skins:
        if armature_modifier.rig_of(skin) != rig:
            raise SinewError(f"{skin.name} follows another armature than {rig.name}: bake it by itself")
