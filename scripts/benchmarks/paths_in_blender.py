"""Measures the paths of muscles in bending joints; see scripts/paths.py.

usage: scripts/run_in_blender.py scripts/benchmarks/paths_in_blender.py OPTIONS, a JSON object
"""

import json
import sys

import bpy
import numpy as np
from bl_ext.user_default.sinew.live import session
from bl_ext.user_default.sinew.muscles import portable_names
from bl_ext.user_default.sinew.scene import characters
from build.layout import SCRIPTS
from data import body_in_blender
from data.myo_names import name_of
from demos.scene import make_active
from mathutils import Matrix

from benchmarks import quality_poses

MODEL = json.loads((SCRIPTS / "data/path_lengths.json").read_text())["joints"]
# heads of the bones at both ends of the limb by which the model is scaled
LIMBS = {"hip": ("upperleg01", "lowerleg01"), "knee": ("upperleg01", "lowerleg01"), "elbow": ("upperarm01", "lowerarm01")}
MOST_DIFFERENCE, MOST_JUMP_MM = 0.05, 1.0
# names of the model's strands that the preset has as one muscle, or spells otherwise
RENAMED = {
    "Adductor magnus, Dist": "Adductor magnus, distal part",
    "Adductor magnus, Isch": "Adductor magnus, ischial part",
    "Adductor magnus, Mid": "Adductor magnus, middle part",
    "Adductor magnus, Prox": "Adductor magnus, proximal part",
    "Extensor digitorum, finger 3": "Extensor digitorum",
    "Flexor digitorum superficialis, finger 4": "Flexor digitorum superficialis",
    "Gluteus maximus, 1": "Gluteus maximus, upper part",
    "Gluteus maximus, 2": "Gluteus maximus, middle part",
    "Gluteus maximus, 3": "Gluteus maximus, lower part",
    "Gluteus medius, 1": "Gluteus medius, anterior part",
    "Gluteus medius, 2": "Gluteus medius, middle part",
    "Gluteus medius, 3": "Gluteus medius, posterior part",
    "Gluteus minimus, 1": "Gluteus minimus, anterior part",
    "Gluteus minimus, 2": "Gluteus minimus, middle part",
    "Gluteus minimus, 3": "Gluteus minimus, posterior part",
    "Psoas major, femoral part": "Psoas major",
}


def lengths_m(rig, joint: str, degrees: range) -> dict[str, np.ndarray]:
    """By portable name of each muscle of the left side: the length of its path at each angle, m."""
    hinge = quality_poses.hinge_of(rig, f"{joint}.L")
    bone = rig.pose.bones[hinge.bone]
    rest = bone.bone.matrix_local.to_3x3()
    state = session.cached_rig(rig)
    tissues = characters.tissues_of(rig)
    portable = {empty: name for name, empty in portable_names.of_rig(rig).items()}
    names = [portable[tissues[index]] for index in state.solved]
    found: dict[str, list[float]] = {name: [] for name in names if name.endswith(".L")}
    for angle in degrees:
        bone.matrix_basis = (rest.inverted() @ hinge.turn(np.radians(angle)) @ rest).to_4x4()
        bpy.context.view_layer.update()
        points, offsets = state.musculature.path_points(state.pose)
        for name, first, last in zip(names, offsets, offsets[1:]):
            if name in found:
                found[name].append(float(np.linalg.norm(np.diff(points[first:last], axis=0), axis=1).sum()))
    bone.matrix_basis = Matrix.Identity(4)
    return {name.removesuffix(".L"): np.array(lengths) for name, lengths in found.items()}


def rows(rig, joint: str) -> list[tuple[str, float, float, float, float]]:
    """For each muscle: its name, change of length in the model and here in mm, difference, and jump in mm."""
    model = MODEL[joint]
    upper, lower = (rig.data.bones[f"{name}.L"].head_local for name in LIMBS[joint])
    scale = 1000 * (lower - upper).length / model["limb_mm"]
    step = model["step_degrees"]
    last = step * (len(next(iter(model["lengths_mm"].values()))) - 1)
    here = lengths_m(rig, joint, range(last + 1))
    result = []
    for strand, wanted in model["lengths_mm"].items():
        name = RENAMED.get(name_of(strand), name_of(strand))
        if name not in here:
            continue
        expected = scale * np.array(wanted)
        got = 1000 * here[name]
        change, expected_change = got[::step] - got[0], expected - expected[0]
        difference = np.abs(change - expected_change).max() / expected[0]
        jump = np.abs(np.diff(got, 2)).max()
        result.append((name, expected_change[-1], change[-1], difference, jump))
    return sorted(result, key=lambda row: -row[3])


def main() -> None:
    options = json.loads(sys.argv[1])
    bpy.ops.wm.read_factory_settings(use_empty=True)
    _skin, rig = body_in_blender.build()
    make_active(rig)
    bpy.ops.sinew.add_preset(name=options["preset"])
    print("| joint | muscle | model, mm | Sinew, mm | difference, % | jump, mm a degree |\n|---|---|---|---|---|---|")
    good = every = 0
    for joint in MODEL:
        for name, expected, got, difference, jump in rows(rig, joint):
            print(f"| {joint} | {name} | {expected:+.0f} | {got:+.0f} | {100 * difference:.1f} | {jump:.2f} |")
            good += difference <= MOST_DIFFERENCE and jump <= MOST_JUMP_MM
            every += 1
    print(f"\n{good} of {every} within {100 * MOST_DIFFERENCE:.0f} % and {MOST_JUMP_MM:g} mm a degree")


if __name__ == "__main__":
    main()
