"""Measures quality inside Blender: poses the body, measures it under each deformer and prints tables.

usage: scripts/run_in_blender.py scripts/benchmarks/quality_in_blender.py OPTIONS.json        (see quality.py)
"""

import json
import sys
from pathlib import Path

import bpy
import _sinew
import numpy as np
from build.console import step

from benchmarks import quality_poses, quality_sections, quality_shape, quality_turntable
from benchmarks.quality_character import LINEAR, SINEW, Character

SIDE = "L"
COLUMNS = ("union", "edge p99", "inverted", "hits", "hits, body", "bend p99")
HOLDS, FAILS = "+", "!"


class Tally:
    """Counts the values that meet the requirements."""

    def __init__(self):
        self.held, self.required = 0, 0

    def mark(self, holds: bool) -> str:
        self.required += 1
        self.held += holds
        return HOLDS if holds else FAILS


def key_table(character: Character, poses, tally: Tally) -> None:
    """Prints each pose under each deformer, with the requirements below."""
    print(f"\n{'':38}" + "".join(f"{column:>13}" for column in COLUMNS))
    for pose in poses:
        joint = f"{pose.joint}.{SIDE}"
        character.pose({joint: pose.degrees})
        region, deformed = character.region(joint), {}
        bar = pose.bar or quality_poses.NO_REQUIREMENTS
        for name in character.shown:
            found = deformed[name] = character.surface.deformed(character.points(name))
            quality = found.quality(region)
            union = quality.union
            holds = (
                bar.least_union <= union <= bar.most_union, quality.edge_p99 <= bar.most_edge,
                quality.inverted == 0, quality.new_intersections == 0, len(found.new_intersections) == 0,
                quality.bend_p99 <= bar.most_bend,
            )  # fmt: skip
            marks = [tally.mark(one) if name == SINEW else " " for one in holds]
            numbers = (
                f"{union:.3f}", f"{quality.edge_p99:.2f}", quality.inverted, quality.new_intersections,
                len(found.new_intersections), f"{quality.bend_p99:.1f}",
            )  # fmt: skip
            label = pose.name if name == LINEAR else ""
            cells = "".join(f"{number:>11} {mark}" for number, mark in zip(numbers, marks, strict=True))
            print(f"{label:<19}{name:<19}{cells}")
        required = ("", "", "0", "0", "0", "")
        if pose.bar:
            required = (bar.volume_text(), f"<= {bar.most_edge:g}", "0", "0", "0", f"<= {bar.most_bend:g}")
        print(
            f"{'':<19}{'required':<19}"
            + "".join(f"{text:>11}  " for text in required)
            + faults_elsewhere(character, region, deformed)
        )
        sys.stdout.flush()


def faults_elsewhere(character: Character, region, deformed) -> str:
    """Faults of Sinew's skin outside the region that linear skinning does not have."""
    outside = np.ones(len(character.triangles), bool)
    outside[region.faces] = False
    sinew, linear = deformed[SINEW], deformed[LINEAR]
    inverted = int((sinew.inverted & ~linear.inverted & outside).sum())
    known = set(map(tuple, linear.new_intersections.tolist()))
    intersections = sum(outside[a] and outside[b] and (a, b) not in known for a, b in sinew.new_intersections.tolist())
    return (
        f"  ! elsewhere, not in linear: {inverted} inverted, {intersections} intersections"
        if inverted or intersections
        else ""
    )


def combined_table(character: Character) -> None:
    """Prints poses of several joints, measured around each joint and over the whole body."""
    print("\nseveral joints at once")
    print(f"{'':34}" + "".join(f"{column:>13}" for column in COLUMNS))
    for pose in quality_poses.COMBINED_POSES:
        character.pose(pose.degrees, pose.makes_fists)
        for name in (LINEAR, SINEW):
            found = character.surface.deformed(character.points(name))
            for around in (*pose.around, None):
                quality = found.quality(character.region(around) if around else character.whole)
                label = f"{name}, {around.replace('_twist', '') if around else 'whole body'}"
                print(
                    f"{pose.name if name == LINEAR and around == pose.around[0] else '':<27}{label:<22}"
                    f"{quality.union:>9.3f} {quality.edge_p99:>12.2f} {quality.inverted:>12} "
                    f"{quality.new_intersections:>12} {len(found.new_intersections):>12} {quality.bend_p99:>12.1f}"
                )
    sys.stdout.flush()


def sweep_table(character: Character, joints) -> None:
    """Prints pop and jitter over sweeps in steps of a degree, compared with linear skinning of the same poses."""
    print(
        f"\n{'1° steps':<16}{'pop excess mm':>14}{'at':>7}{'persistence':>13}{'over body mm':>14}"
        f"{'jitter':>9}{'its excess':>12}"
    )
    for joint in joints:
        first, last = quality_poses.SWEEPS[joint]
        frames = {name: [] for name in (SINEW, LINEAR)}
        for degrees in range(first, last + 1):
            character.pose({f"{joint}.{SIDE}": degrees})
            for name, points in frames.items():
                points.append(character.points(name))
        counted = np.zeros(len(character.rest), bool)
        counted[character.triangles[character.region(f"{joint}.{SIDE}").faces]] = True
        skin, reference = np.array(frames[SINEW]), np.array(frames[LINEAR])
        motion, body = _sinew.SkinMotion(skin, reference, counted), _sinew.SkinMotion(skin, reference)
        linear_jitter = max(motion.jitter_reference_p99, 1e-12)
        print(
            f"{joint.replace('_', ' '):<16}{1000 * motion.pop_excess:>14.3f}{first + motion.pop_frame:>6}°"
            f"{motion.pop_persistence:>13.2f}{1000 * body.pop_excess:>14.3f}{motion.jitter_p99 / linear_jitter:>9.2f}"
            f"{motion.jitter_excess_p99 / linear_jitter:>12.2f}"
        )
        sys.stdout.flush()
    print("pop: how much further a vertex moves in a degree than with linear skinning (required: <= 1)")
    print("jitter: divided by that of linear skinning")


def shape_tables(character: Character) -> None:
    print("\ncrease gap of Sinew's skin, mm: smallest, and median over skin that faces the other side (required: <= 2)")
    for joint, degrees in quality_shape.CREASES:
        character.pose({f"{joint}.{SIDE}": degrees})
        gap = quality_shape.crease_gap(character, f"{joint}.{SIDE}", character.points(SINEW))
        print(f"{joint} {degrees}°".ljust(16) + (f"{gap[0]:.1f}, {gap[1]:.1f}" if gap else "no skin faces the other side"))
    print("\nmuscles raise the skin, mm: mean and largest, compared with the same skin at Muscle Influence 0")
    for name, found in quality_shape.rises(character).items():
        (joint, degrees), _ = quality_poses.RISES[name]
        cells = (f"{state} {mean:.1f}, {most:.1f}" for state, (mean, most) in found.items())
        print(f"{name} ({joint} {degrees}°)".ljust(28) + "   ".join(cells))
    sys.stdout.flush()


def main(options: dict) -> None:
    unknown = {*options["only"], *(joint for joint, _ in options["poses"])} - quality_poses.SWEEPS.keys()
    if unknown:
        raise SystemExit(f"sinew: Unknown joint {', '.join(sorted(unknown))}. Choose from {', '.join(quality_poses.SWEEPS)}")
    with step(f"the body with the preset '{options['preset']}'"):
        character = Character(options["preset"], options["iterations"])
    if options["save"]:
        bpy.ops.wm.save_as_mainfile(filepath=options["save"], compress=True)
    character.add_blenders_own()
    only = options["only"] or list(quality_poses.SWEEPS)
    tables, tally = options["tables"], Tally()
    poses = [quality_poses.key_pose(*pose) for pose in options["poses"]]
    poses = poses or [pose for pose in quality_poses.KEY_POSES if pose.joint in only]
    if "key" in tables:
        key_table(character, poses, tally)
        print(f"\n{tally.held} of {tally.required} requirements are met ({HOLDS}); {FAILS} is not")
    if "combined" in tables:
        combined_table(character)
    if "shape" in tables:
        shape_tables(character)
    if "sweep" in tables:
        sweep_table(character, only)
    if options["pictures"]:
        folder = Path(options["pictures"])
        with step("section pictures"):
            quality_sections.draw(character, folder / "sections.png")
        with step("the turntable"):
            quality_turntable.render(character, folder / "turntable.png")


if __name__ == "__main__":
    main(json.loads(sys.argv[1]))
