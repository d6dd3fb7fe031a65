"""Makes addon/presets/myo.json: the 416 muscles of MyoSuite's whole body as fractions of Sinew's segments.

usage: python3 scripts/run_in_blender.py scripts/make_myo_preset.py MYOFULLBODY_MUSCLES.json

The model (PyPI myo_sim 0.2.4, myofullbody, Apache-2.0) gives each muscle a path of points on its bodies, measured in the
rest pose. The script builds an armature with the model's joints, lets Sinew recognize the segments in it, and writes each
point as (segment, along, around, depth). The model has no skin, so a depth is a fraction of the segment's usual radius. The
model has no widths either, so a belly's cross-section follows from the muscle's peak force. The left half is written for
both sides.
"""

import json
import math
import re
import sys
from pathlib import Path

import bpy
import numpy as np
from bl_ext.user_default.sinew.muscles.placing.place import placement
from bl_ext.user_default.sinew.muscles.placing.recognise import segments
from bl_ext.user_default.sinew.muscles.placing.recognise.body import Body, Segment
from build.layout import ROOT
from data.myo_names import belly_of, group_of, name_of
from mathutils import Quaternion, Vector

TARGET = ROOT / "addon" / "presets" / "myo.json"
SOURCE = (
    "myo_sim 0.2.4 (PyPI), model myofullbody, Apache-2.0: paths and peak forces of {}, mapped by scripts/make_myo_preset.py"
)
FORCE_OF_AREA = 6.0e5  # N/m²: the value that the makers of the model used
AREA_OF_BELLY = (
    0.9  # area in the middle of an ellipsoid with the muscle's volume, divided by its physiological cross-section
)
THICKNESS_RATIO = 0.65
VIA_APART = (
    0.15  # fraction of the length; a via point nearer to the last one or to the end is left out: the path would swing
)
VIA_OFF_LINE = 0.05  # fraction of the length; a via point nearer to the straight path is left out
NECK = (-0.025, 0.225, 1.56)  # the seventh cervical vertebra: the model's cervical body begins at the first rib

# (bone, parent, body at its head), with the bone names of a VRM humanoid
BONES = (
    ("hips", None, "pelvis"),
    ("spine", "hips", "lumbar5"),
    ("chest", "spine", "lumbar1"),
    ("neck", "chest", NECK),
    ("head", "neck", "head"),
    ("{side}Shoulder", "chest", "clavicle_{s}"),
    ("{side}UpperArm", "{side}Shoulder", "humerus_{s}"),
    ("{side}LowerArm", "{side}UpperArm", "ulna_{s}"),
    ("{side}Hand", "{side}LowerArm", "lunate_{s}"),
    ("{side}IndexProximal", "{side}Hand", "2proxph_{s}"),
    ("{side}MiddleProximal", "{side}Hand", "3proxph_{s}"),
    ("{side}RingProximal", "{side}Hand", "4proxph_{s}"),
    ("{side}LittleProximal", "{side}Hand", "5proxph_{s}"),
    ("{side}UpperLeg", "hips", "femur_{s}"),
    ("{side}LowerLeg", "{side}UpperLeg", "tibia_{s}"),
    ("{side}Foot", "{side}LowerLeg", "talus_{s}"),
    ("{side}Toes", "{side}Foot", "toes_{s}"),
)
# Pattern of a body (without its side), the segments that a point on it may be relative to, the segment that it moves with.
SEGMENTS_OF_BODY = (
    (r"sacrum|pelvis", ("pelvis", "abdomen"), "pelvis"),
    (r"lumbar\d|Abdomen", ("abdomen", "pelvis", "chest"), "abdomen"),
    (r"torso|chest", ("chest", "abdomen"), "chest"),
    (r"clavicle|scapula", ("shoulder_girdle", "chest"), "shoulder_girdle"),
    (r"humerus", ("upper_arm",), "upper_arm"),
    (r"ulna|radius", ("forearm",), "forearm"),
    (r"femur", ("thigh",), "thigh"),
    (r"tibia|patella", ("shin",), "shin"),
    (r"talus|calcn|toes", ("shin",), "foot"),
    (r".*", ("hand",), "hand"),
)


class Model:
    """The muscles and their points in the model's rest pose, in m. The middle of the body is at x = 0."""

    def __init__(self, path: Path):
        data = json.loads(path.read_text(encoding="utf-8"))
        self.bodies = data["bodies"]
        self.muscles = [muscle for muscle in data["muscles"] if muscle["name"].endswith("_l")]
        self.middle = Vector((self.bodies["pelvis"]["world_pos"][0], 0, 0))

    def point(self, body: str, local=(0.0, 0.0, 0.0)) -> Vector:
        at = self.bodies[body]
        return Quaternion(at["world_quat_wxyz"]) @ Vector(local) + Vector(at["world_pos"]) - self.middle


def armature(model: Model) -> bpy.types.Object:
    """The model's joints as a rig."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    data = bpy.data.armatures.new("Myo")
    rig = bpy.data.objects.new("Myo", data)
    bpy.context.scene.collection.objects.link(rig)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    for name, parent, body in BONES:
        for side, s, sign in (("left", "l", 1), ("right", "l", -1)) if "{side}" in name else (("", "", 1),):
            bone = data.edit_bones.new(name.replace("{side}", side))
            head = Vector(body) - model.middle if isinstance(body, tuple) else model.point(body.replace("{s}", s))
            bone.head = Vector((head.x * sign if side else 0.0, head.y, head.z))
            bone.tail = bone.head + Vector((0, 0, 0.18 if name == "head" else 0.05))
            if parent:
                bone.parent = data.edit_bones[parent.replace("{side}", side)]
    bpy.ops.object.mode_set(mode="OBJECT")
    return rig


def without_long_tendons(path: list) -> list:
    """The path up to the first point on a hand or foot. The rest, to the fingers or toes, is tendon."""
    for end in range(1, len(path)):
        if _extremity(path[end][0]) and not _extremity(path[0][0]):
            return path[: end + 1]
    return path


def _extremity(body_name: str) -> bool:
    return _carrier(body_name)[1] in ("hand", "foot")


def _carrier(body_name: str) -> tuple[tuple[str, ...], str]:
    plain = re.sub(r"_[lr]$", "", body_name)
    return next((roles, role) for pattern, roles, role in SEGMENTS_OF_BODY if re.fullmatch(pattern, plain))


def attachment(point: Vector, body_name: str, body: Body) -> dict:
    """A point in a preset's terms, relative to the segment that contains it, or to the one that it is least outside of."""
    roles, carrier = _carrier(body_name)
    position = min((_relative_to(point, body.segment(role, "L")) for role in roles), key=lambda at: at["outside"])
    outside = position.pop("outside")
    if carrier == "foot":  # a straight line to the toes would leave the shin: the tendon bends at the ankle
        position |= {"along": min(position["along"], 1.02), "depth": min(position["depth"], 0.7)}
    if carrier == "hand":
        position |= {"along": min(position["along"], 1.0), "depth": min(position["depth"], 0.7)}
    if outside > 1.0:
        print(f"  {body_name}: a point is {outside:.1f} outside of its segment", file=sys.stderr)
    return position if position["segment"] == carrier else position | {"carried_by": carrier}


def _relative_to(point: Vector, segment: Segment) -> dict:
    along = segment.along(point)
    across = point - segment.point(along)
    around = math.degrees(math.atan2(across.dot(segment.outer), across.dot(segment.front))) % 360.0
    depth = across.length / placement.usual_radius(segment, across.normalized()) if across.length > 1e-6 else 0.0
    outside = max(0.0, -along, along - 1.0) + max(0.0, depth - 1.0)
    return {
        "segment": segment.role,
        "along": round(min(max(along, -3.0), 3.0), 3),
        "around": round(around, 1) % 360.0,
        "depth": round(min(depth, 0.95), 3),
        "outside": outside,
    }


def straightened(points: list[Vector]) -> list[int]:
    """The indices of the points that a path needs (Douglas and Peucker 1973). The first and the last are always kept."""

    def needed(first: int, last: int) -> list[int]:
        line = points[last] - points[first]
        if last - first < 2 or line.length < 1e-6:
            return []
        along = line.normalized()
        off = [(point - points[first] - along * (point - points[first]).dot(along)).length for point in points]
        worst = max(range(first + 1, last), key=lambda i: off[i])
        if off[worst] < VIA_OFF_LINE * line.length:
            return []
        return [*needed(first, worst), worst, *needed(worst, last)]

    kept = [0]
    for i in needed(0, len(points) - 1):
        gap_m = min((points[i] - points[kept[-1]]).length, (points[i] - points[-1]).length)
        if gap_m > VIA_APART * (points[-1] - points[0]).length:
            kept.append(i)
    return [*kept, len(points) - 1]


def tissue(muscle: dict, model: Model, body: Body) -> dict:
    """The preset's entry for one muscle of the model."""
    path = muscle["path"]
    if re.match(r"humerus", path[0][0]) and re.match(r"scapula|clavicle|chest", path[-1][0]):
        path = path[::-1]  # the model lists these from the arm to the trunk
    path = without_long_tendons(path)
    positions = [model.point(name, local) for name, local in path]
    within_hand = all(_carrier(name)[1] == "hand" for name, _ in path)
    kept = [0, len(path) - 1] if within_hand else straightened(positions)
    attachments = [attachment(positions[i], path[i][0], body) for i in kept]
    length_m = (positions[-1] - positions[0]).length
    origin_tendon, insertion_tendon = tendons(path, positions)
    area_m2 = AREA_OF_BELLY * muscle["peak_force_N"] / FORCE_OF_AREA
    width_m = 2 * math.sqrt(area_m2 / (math.pi * THICKNESS_RATIO))
    belly_m = length_m * (1 - origin_tendon - insertion_tendon)
    entry = {
        "name": name_of(muscle["name"]),
        "kind": "MUSCLE",
        "group": group_of(muscle["name"]),
        "sides": ["L", "R"],
        "origin": attachments[0],
        "insertion": attachments[-1],
        "origin_tendon": round(origin_tendon, 3),
        "insertion_tendon": round(insertion_tendon, 3),
        "width_ratio": round(float(np.clip(width_m / belly_m, 0.03, 0.9)), 3),
        "thickness_ratio": THICKNESS_RATIO,
    }
    belly = belly_of(muscle["name"])
    return entry | ({"via": attachments[1:-1]} if len(attachments) > 2 else {}) | ({"belly": belly} if belly else {})


def tendons(path: list, positions: list[Vector]) -> tuple[float, float]:
    """The two tendons as fractions of the length. A belly that moves a hand or foot ends well before wrist or ankle."""
    first, last = (re.sub(r"_[lr]$", "", path[end][0]) for end in (0, -1))
    if re.match(r"humerus|ulna|radius", first) and not re.match(r"humerus|ulna|radius", last):
        return 0.05, 0.55 if re.search(r"\dproxph|midph|distph|distal", last) else 0.42
    if re.match(r"femur|tibia", first) and re.match(r"calcn|toes|talus", last):
        return 0.04, 0.45
    if re.match(r"pelvis|femur", first) and re.match(r"tibia|patella", last):
        return 0.08, 0.2
    return 0.08, 0.1


def main() -> None:
    source = Path(sys.argv[1])
    if not source.is_file():
        sys.exit(f"sinew: There is no file {source}. Pass the muscles of PyPI's myo_sim 0.2.4, model myofullbody, as JSON")
    model = Model(source)
    body = segments.recognise(armature(model))
    tissues = [tissue(muscle, model, body) for muscle in model.muscles]
    groups: dict[str, list[str]] = {}
    for muscle in model.muscles:
        groups.setdefault(group_of(muscle["name"]), []).append(muscle["name"].removesuffix("_l"))
    preset = {
        "sinew_preset": 1,
        "name": "Myo",
        "description": "All 416 muscles of MyoSuite's measured body, strand by strand or joined to bellies",
        "sources": {group: SOURCE.format(", ".join(names))[:1000] for group, names in groups.items()},
    }
    head = json.dumps(preset, indent=2, ensure_ascii=False).removesuffix("\n}")
    rows = ",\n".join(f"    {json.dumps(entry, ensure_ascii=False)}" for entry in tissues)
    TARGET.write_text(f'{head},\n  "tissues": [\n{rows}\n  ]\n}}\n', encoding="utf-8")
    print(f"{2 * len(tissues)} muscles in {TARGET.relative_to(ROOT)}, {TARGET.stat().st_size // 1000} kB")


if __name__ == "__main__":
    main()
