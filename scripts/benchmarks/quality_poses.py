"""The poses in which quality is measured, and the requirements of each. Angles are anatomical, as in demos/motion.py."""

import math
from dataclasses import dataclass, field

from demos import motion
from mathutils import Matrix, Vector


@dataclass(frozen=True)
class Bar:
    """The requirements of a pose. Inverted faces and new self-intersections must be 0 in every pose."""

    least_union: float
    most_union: float
    most_edge: float
    most_bend: float

    def volume_text(self) -> str:
        return f">= {self.least_union:g}" if math.isinf(self.most_union) else f"{self.least_union:g}..{self.most_union:g}"


NO_REQUIREMENTS = Bar(0.0, math.inf, math.inf, math.inf)


@dataclass(frozen=True)
class KeyPose:
    """One joint at an angle, all others at rest."""

    joint: str
    degrees: int
    bar: Bar | None  # None: the pose only has to be free of faults

    @property
    def name(self) -> str:
        return f"{self.joint.replace('_', ' ')} {self.degrees}°"


KEY_POSES = (
    KeyPose("elbow", 90, Bar(0.995, 1.005, 1.65, 35)),
    KeyPose("elbow", 120, Bar(0.995, 1.005, 1.8, 45)),
    KeyPose("elbow", 150, Bar(0.985, math.inf, 1.9, 55)),
    KeyPose("knee", 90, Bar(0.995, 1.005, 1.55, 40)),
    KeyPose("knee", 140, Bar(0.985, math.inf, 1.6, 70)),
    KeyPose("hip", 90, Bar(0.985, math.inf, 2.2, 60)),
    KeyPose("hip", 110, Bar(0.985, math.inf, 2.6, 65)),
    KeyPose("shoulder", 90, Bar(0.99, 1.01, 1.5, 33)),
    KeyPose("shoulder", 135, Bar(0.99, 1.01, 1.9, 42)),
    KeyPose("forearm_twist", 90, Bar(0.995, 1.005, 1.2, 16)),
    KeyPose("wrist_twist", 90, Bar(0.995, 1.005, 1.3, 20)),
)


def key_pose(joint: str, degrees: int) -> KeyPose:
    """The key pose of a joint at an angle, or a new pose without requirements."""
    known = (pose for pose in KEY_POSES if (pose.joint, pose.degrees) == (joint, degrees))
    return next(known, KeyPose(joint, degrees, None))


# first and last degree
SWEEPS = {
    "elbow": (0, 150),
    "knee": (0, 140),
    "shoulder": (0, 135),
    "hip": (0, 110),
    "forearm_twist": (0, 90),
    "wrist_twist": (0, 90),
}


@dataclass(frozen=True)
class CombinedPose:
    """Several joints at once, and the joints around which the pose is measured.

    degrees: by joint. If two joints belong to one bone, the one nearer to the body comes first.
    """

    name: str
    degrees: dict[str, float] = field(default_factory=dict)
    around: tuple[str, ...] = ()
    makes_fists: bool = False


def both(**degrees: float) -> dict[str, float]:
    """The same angles on both sides."""
    return {f"{joint}.{side}": angle for side in "LR" for joint, angle in degrees.items()}


COMBINED_POSES = (
    CombinedPose("arm folded to the shoulder", both(shoulder=75, elbow=150), ("elbow.L", "shoulder.L")),
    CombinedPose("squat", both(hip=105, knee=135), ("hip.L", "knee.L", "hip.R", "knee.R")),
    CombinedPose("fists", both(elbow=90), ("wrist_twist.L", "elbow.L"), makes_fists=True),
    CombinedPose(
        "hand on the other shoulder",
        {"forward.L": 78, "shoulder.L": -10, "outward01.L": -60, "outward02.L": -20, "elbow.L": 112},
        ("shoulder.L", "elbow.L"),
    ),
)

# muscles that tense in a pose, to measure how far they raise the skin: pose, starts of the muscles' names
RISES = {
    "biceps": (("elbow", 120), ("Biceps brachii",)),
    "deltoid": (("shoulder", 90), ("Deltoid",)),
    "quadriceps": (("hip", 60), ("Rectus femoris", "Vastus")),
    "calf": (("knee", 60), ("Gastrocnemius", "Soleus")),
}


def rotations_of(rig, degrees: dict[str, float], makes_fists: bool = False) -> dict[str, Matrix]:
    """The rest-space rotation of each bone of a pose."""
    rotations: dict[str, Matrix] = {}
    for joint, angle in degrees.items():
        hinge = hinge_of(rig, joint)
        rotations[hinge.bone] = rotations.get(hinge.bone, Matrix.Identity(3)) @ hinge.turn(math.radians(angle))
    return rotations | (_fists(rig) if makes_fists else {})


def hinge_of(rig, joint: str) -> motion.Hinge:
    """Like `motion.hinge`, with the additional joint `forward`, which lifts the upper arm in front of the body."""
    kind, side = joint.split(".")
    if kind == "forward":
        return motion.Hinge(f"upperarm01.{side}", Vector((-1, 0, 0)), 0.0)
    return motion.hinge(rig, joint)


def radius_of(rig, joint: str) -> float:
    """The radius of the skin that is measured around a joint, in m: half of the shorter limb segment at the joint."""
    kind, side = joint.split(".")

    def length(start: str, end: str) -> float:
        bones = rig.data.bones
        return (bones[f"{end}.{side}"].head_local - bones[f"{start}.{side}"].head_local).length

    arm = length("upperarm01", "lowerarm01"), length("lowerarm01", "wrist")
    leg = length("upperleg01", "lowerleg01"), length("lowerleg01", "foot")
    lengths = {"elbow": min(arm), "knee": min(leg), "hip": leg[0], "shoulder": arm[0]}
    return 0.5 * lengths.get(kind, arm[1])


def _fists(rig) -> dict[str, Matrix]:
    """The rotations that curl fingers 2 to 5 of both hands, each in the direction in which it is bent at rest."""
    rotations = {}
    for side in "LR":
        for finger in range(2, 6):
            links = [rig.data.bones[f"finger{finger}-{link}.{side}"] for link in (1, 2, 3)]
            along = [(link.tail_local - link.head_local).normalized() for link in links]
            axis = (along[0].cross(along[1]) + along[1].cross(along[2])).normalized()
            for link, degrees in zip(links, (60, 85, 60), strict=True):
                rotations[link.name] = Matrix.Rotation(math.radians(degrees), 3, axis)
    return rotations
