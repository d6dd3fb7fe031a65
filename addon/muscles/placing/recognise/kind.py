# SPDX-License-Identifier: GPL-3.0-or-later
"""Which kind of creature a rig is: a human, a quadruped, a bird, a fish, an arthropod, or another.

Every fact that was found adds points to kinds or takes some away (`_name_facts`, `_shape_facts`). The kind with the most
points is the answer; how sure it is follows from its lead, as a softmax of the points. Names count because whoever made
the rig knew what it is; the shape counts because it does not depend on words. Works for any armature; nothing here raises.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from bpy.types import Bone, Object

from ....scene import characters, skinned_bones
from ....scene.skinned_bones import SkinnedBones
from . import fish, names
from .body_space import BodySpace, body_space
from .kind_words import kinds_of_animals, kinds_of_parts
from .limbs import Limb, limbs_of
from .name_words import OF_ARM, OF_LEG, Reading

HUMAN, QUADRUPED, BIRD, FISH, ARTHROPOD, OTHER = KINDS = ("human", "quadruped", "bird", "fish", "arthropod", "other")
LABELS = {
    HUMAN: "a human",
    QUADRUPED: "an animal on four legs",
    BIRD: "a bird",
    FISH: "a fish",
    ARTHROPOD: "an insect, a spider or a crab",
    OTHER: "another creature",
}
GROUND_OF_HEIGHT = 0.15  # a limb whose lowest joint is within this fraction of the height above the ground stands on it
LEAST_DROP = (
    0.25  # of a limb's start above its lowest joint, as a fraction of the height of the start: fins do not reach down
)
UPRIGHT_SINE, LYING_SINE = 0.75, 0.5  # of the angle of the trunk with the ground, between hips and shoulders
SHORT_ARM = 0.55  # arms shorter than this fraction of the legs are not those of a human or the wings of a bird
LONG_WING = 0.9  # limbs off the ground at least this long, as a fraction of the legs, can be wings
ELONGATED = 3.5  # length over height of a mesh, from which it is a fish or a snake
LONG_AS_SNAKE = 12.0
DIGITS, FEWEST_DIGITS = {"thumb", "index", "middle", "ring", "little"}, 3
START_OF_OTHER = 1.5  # points of "other" at the start: what a kind needs before it is named


@dataclass(frozen=True)
class Fact:
    """One fact about a rig, in words, and the points that it gives to kinds."""

    text: str
    points: Mapping[str, float]


@dataclass(frozen=True)
class Kind:
    """The kind of a creature. name: one of KINDS. sureness: 0 to 1. facts: what speaks for it, the strongest first."""

    name: str
    sureness: float
    facts: tuple[str, ...]

    @property
    def text(self) -> str:
        """For the user: "an animal on four legs (98 % sure: two pairs of legs by name, ...)"."""
        why = f": {', '.join(self.facts[:3])}" if self.facts else ""
        return f"{LABELS[self.name]} ({min(round(100 * self.sureness), 99)} % sure{why})"


def kind_of(rig: Object, skinned: SkinnedBones | None = None, object_names: Iterable[str] = ()) -> Kind:
    """The kind of creature that a rig is.

    skinned: which bones carry skin; without it all bones count. object_names: of the armature and its meshes.
    """
    readings = names.readings_of(rig)
    carriers = skinned.carriers(rig) if skinned is not None else set()
    bones = [bone for bone, reading in readings.items() if not reading.control and (not carriers or bone.name in carriers)]
    facts = _name_facts(rig, readings, bones, object_names)
    if len(bones) > 1:
        space = body_space(rig, readings, bones)
        if space.size > 0.0 and math.isfinite(space.size):
            facts += _shape_facts(rig, space, bones, readings, skinned)
    points = {kind: sum(fact.points.get(kind, 0.0) for fact in facts) for kind in KINDS}
    points[OTHER] += START_OF_OTHER
    best = max(KINDS, key=lambda kind: points[kind])
    sureness = 1.0 / sum(math.exp(points[kind] - points[best]) for kind in KINDS)
    speaking = sorted((fact for fact in facts if fact.points.get(best, 0.0) > 0), key=lambda fact: -fact.points[best])
    return Kind(best, sureness, tuple(fact.text for fact in speaking))


def object_names(rig: Object) -> list[str]:
    """The names of a rig, of its armature data and of its meshes."""
    return [rig.name, rig.data.name, *(name for skin in characters.skins_of(rig) for name in (skin.name, skin.data.name))]


def kind_of_character(rig: Object) -> Kind:
    """The kind of creature that a rig and its meshes are."""
    return kind_of(rig, skinned_bones.skinned_bones(rig, characters.skins_of(rig)), object_names(rig))


# Names


def _name_facts(rig: Object, readings: Mapping[Bone, Reading], bones: list[Bone], object_names: Iterable[str]) -> list[Fact]:
    facts = []
    legs = names.leg_pairs(rig)
    sided = [reading for bone in bones if (reading := readings[bone]).side and not reading.other]
    arms = any(reading.part in ("upper_arm", "arm", "elbow", "forearm") and not reading.front for reading in sided)
    hands = any(reading.part in OF_ARM - {"girdle", "shoulder", "upper_arm", "arm", "elbow", "forearm"} for reading in sided)
    parts = {reading.part for bone, reading in readings.items() if bone in set(bones) and not reading.control}
    if legs >= 3:
        facts.append(Fact(f"{legs} pairs of legs by name", {ARTHROPOD: 4.0, HUMAN: -4.0, QUADRUPED: -3.0, BIRD: -3.0}))
    elif legs == 2:
        facts.append(Fact("two pairs of legs by name", {QUADRUPED: 3.0, HUMAN: -1.0}))
    elif legs == 1 and arms:
        facts.append(Fact("arms and legs by name", {HUMAN: 2.5}))
    elif arms and hands and parts & {"head", "neck", "trunk"}:
        facts.append(Fact("arms and hands by name", {HUMAN: 2.0}))
    elif any(reading.part in OF_LEG for reading in sided):
        facts.append(Fact("legs by name", {HUMAN: 0.5, BIRD: 0.5, QUADRUPED: 0.5}))
    if len({reading.part for reading in sided} & DIGITS) >= FEWEST_DIGITS:
        facts.append(Fact("fingers by name", {HUMAN: 1.0}))
    if hands:
        facts.append(Fact("hands by name", {HUMAN: 1.0, OTHER: 0.5, FISH: -1.0}))
    if "wing" in parts:
        is_armed = arms and hands
        facts.append(
            Fact("wings by name", {HUMAN: -0.5, BIRD: 0.5 if legs >= 2 or is_armed else 3.0, FISH: -2.0, QUADRUPED: -0.5})
        )
    if "fin" in parts:
        facts.append(Fact("fins by name", {FISH: 2.5, HUMAN: -1.0, QUADRUPED: -1.0}))
    for kind, words in kinds_of_parts(bone.name for bone in bones).items():
        strength = 2.0 + 0.5 * min(len(words) - 1, 2)
        facts.append(Fact(f"bones named {', '.join(sorted(words)[:3])}", {kind: strength}))
    for kind, words in kinds_of_animals(object_names).items():
        facts.append(Fact(f"an object named {', '.join(sorted(words)[:2])}", {kind: 1.0}))
    return facts


# Shape


def _shape_facts(
    rig: Object, space: BodySpace, bones: list[Bone], readings: Mapping[Bone, Reading], skinned: SkinnedBones | None
) -> list[Fact]:
    limbs = limbs_of(space, bones, readings, ())
    lowest, highest = _heights(space, bones, skinned)
    height = max(highest - lowest, 1e-9)
    standing = [limb for limb in limbs if _stands(limb, _lowest(limb, space, skinned), lowest, height, readings)]
    lifted = [limb for limb in limbs if limb not in standing]
    sine = _sine_of_trunk(standing, lifted, space, bones, readings)
    facts = _facts_of_legs(standing, lifted, readings, is_upright=sine is not None and sine > UPRIGHT_SINE)
    facts += _facts_of_trunk(sine)
    named = any(readings[bone].part in OF_ARM | OF_LEG for bone in bones)
    if not limbs and not named:
        facts.append(Fact("no limbs", {OTHER: 1.5, HUMAN: -3.0, QUADRUPED: -3.0, BIRD: -2.0, ARTHROPOD: -2.0}))
        points = skinned.points if skinned is not None else np.empty((0, 3))
        if fish.has_level_spine(space, bones, readings, points):
            facts.append(Fact("a straight level spine", {FISH: 2.5}))
    slender = _slenderness(space, skinned)
    if slender > LONG_AS_SNAKE:
        facts.append(Fact("a long thin body", {OTHER: 1.5, FISH: -0.5}))
    elif slender > ELONGATED and not standing and not named:
        facts.append(Fact("a long body without legs", {FISH: 1.0}))
    return facts


def _facts_of_legs(
    standing: list[Limb], lifted: list[Limb], readings: Mapping[Bone, Reading], *, is_upright: bool
) -> list[Fact]:
    named_legs = {root for root in map(_root, lifted) if readings[root].part in OF_LEG or readings[root].front}
    if len(standing) >= 3:
        return [Fact(f"{len(standing)} pairs of limbs on the ground", {ARTHROPOD: 3.0, HUMAN: -3.0, QUADRUPED: -2.0})]
    if len(standing) == 2:
        return [Fact("two pairs of limbs on the ground", {QUADRUPED: 2.5, HUMAN: -3.0, BIRD: -2.0, FISH: -2.0})]
    if not standing and not any(reading.part in OF_LEG for reading in readings.values()):
        return [Fact("no legs", {HUMAN: -1.5})]
    if len(standing) != 1:
        return []
    facts = [Fact("one pair of limbs on the ground", {HUMAN: 0.5, BIRD: 0.5, QUADRUPED: -1.5, FISH: -1.0})]
    [leg] = standing
    upper = [limb.length for limb in lifted if limb.parent is not None]
    if named_legs and is_upright:
        facts.append(Fact("legs by name where arms are", {HUMAN: 1.0, QUADRUPED: -3.0}))
    elif named_legs:
        facts.append(Fact("front legs that do not reach the ground", {OTHER: 2.0, QUADRUPED: -3.0, HUMAN: -1.0}))
    if upper and max(upper) < SHORT_ARM * leg.length:
        facts.append(Fact("arms much shorter than the legs", {OTHER: 1.0, HUMAN: -1.0, BIRD: -1.0}))
    elif upper and max(upper) > LONG_WING * leg.length:
        facts.append(Fact("limbs off the ground as long as the legs", {BIRD: 1.0}))
    return facts


def _sine_of_trunk(
    standing: list[Limb], lifted: list[Limb], space: BodySpace, bones: list[Bone], readings: Mapping[Bone, Reading]
) -> float | None:
    """The sine of the angle of the trunk with the ground: from the roots of the hind legs to those of the other limbs, or to
    the head. None if there are no legs, more than two pairs, or nothing but legs.
    """
    roots = [limb.points[0] for limb in standing]
    if len(standing) == 1:
        hips = roots[0]
        face = [space.head(bone) for bone in bones if readings[bone].part in ("head", "neck") and not readings[bone].other]
        tops = [limb.points[0] for limb in lifted if limb.points[0].z > hips.z] or face
        if not tops:
            return None
        top = max(tops, key=lambda point: (point - hips).length)
    elif len(standing) == 2:
        hips, top = sorted(roots, key=lambda point: point.z)
    else:
        return None
    along = top - hips
    along.x = 0.0
    return along.z / along.length if along.length > 1e-9 else None


def _facts_of_trunk(sine: float | None) -> list[Fact]:
    if sine is None:
        return []
    if sine > UPRIGHT_SINE:
        return [Fact("an upright trunk", {HUMAN: 2.0, QUADRUPED: -2.0, FISH: -2.0, ARTHROPOD: -1.0})]
    if sine < LYING_SINE:
        return [Fact("a horizontal trunk", {HUMAN: -3.0, QUADRUPED: 1.0, BIRD: 1.0, ARTHROPOD: 0.5})]
    return [Fact("a sloping trunk", {HUMAN: -0.5, BIRD: 0.5, OTHER: 0.5})]


def _root(limb: Limb) -> Bone:
    return limb.bones[0]


def _stands(limb: Limb, low: float, lowest: float, height: float, readings: Mapping[Bone, Reading]) -> bool:
    """Whether a limb, down to the height `low`, reaches the ground from above it."""
    if any(readings[bone].part in ("wing", "fin", "tail") for bone in limb.bones):
        return False
    drop = limb.points[0].z - low
    return low < lowest + GROUND_OF_HEIGHT * height and drop > LEAST_DROP * (limb.points[0].z - lowest)


def _lowest(limb: Limb, space: BodySpace, skinned: SkinnedBones | None) -> float:
    """The height of the lowest joint or skin of a limb, whose end is a tail that can point anywhere."""
    points = skinned.points_of({bone.name for bone in limb.bones}) if skinned is not None else ()
    return min(limb.lowest, float(space.heights(points).min())) if len(points) else limb.lowest


def _heights(space: BodySpace, bones: list[Bone], skinned: SkinnedBones | None) -> tuple[float, float]:
    """The lowest and the highest height of the skin; of the bones without a skin. A tail or a root can lie on the ground."""
    if skinned is not None and len(skinned.points):
        heights = space.heights(skinned.points)
        return float(heights.min()), float(heights.max())
    at = [point.z for bone in bones for point in (space.head(bone), space.end(bone))]
    return min(at), max(at)


def _slenderness(space: BodySpace, skinned: SkinnedBones | None) -> float:
    """The length of the mesh over its height; 1 without a mesh."""
    if skinned is None or not len(skinned.points):
        return 1.0
    length, height = (float(np.ptp(skinned.points @ np.array(space.to_body[axis][:3]))) for axis in (1, 2))
    return length / height if height > 1e-9 else 1.0
