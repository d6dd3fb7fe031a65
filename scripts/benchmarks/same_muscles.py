"""Compares the muscles of one preset on files that hold the same body with different rigs, and prints a Markdown table.

usage: python3 scripts/run_in_blender.py scripts/benchmarks/same_muscles.py [--preset NAME] REFERENCE FILE...

For each FILE: how many muscles it has of those of REFERENCE, and the largest and the median difference of their lengths from
origin to insertion. The names of muscles that differ by more than 2 % are listed below, the largest difference first.
"""

import argparse
import statistics
import sys
from pathlib import Path

import bpy
from bl_ext.user_default.sinew.scene import characters, tissue_empty

from benchmarks.recognition_table import captured, load

ALLOWED = 0.02


def lengths(path: Path, preset: str) -> dict[str, float]:
    """The length of each muscle from origin to insertion, in units of the body's height."""
    with captured([]):
        rig = load(path)
        bpy.context.view_layer.objects.active = rig
        bpy.ops.sinew.add_preset(name=preset)
    shapes = [tissue_empty.read(empty, rig) for empty in characters.tissues_of(rig)]
    points = [vertex.co.z for skin in characters.skins_of(rig) for vertex in skin.data.vertices]
    height = max(points) - min(points)
    return {shape.name: (shape.insertion - shape.origin).length / height for shape in shapes if shape.kind == "MUSCLE"}


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--preset", default="human")
    parser.add_argument("files", metavar="FILE", nargs="+", type=Path)
    wanted = parser.parse_args(sys.argv[1:])
    reference, *others = wanted.files
    known = lengths(reference, wanted.preset)
    print(f"{len(known)} muscles on {reference.name}\n")
    print("| file | muscles | within 2 % | median | largest |\n|---|---|---|---|---|")
    listed = []
    for path in others:
        found = lengths(path, wanted.preset)
        errors = {name: abs(found[name] / known[name] - 1) for name in known if name in found}
        within = sum(error <= ALLOWED for error in errors.values())
        median, largest = statistics.median(errors.values()), max(errors.values())
        print(f"| {path.name} | {len(errors)} | {within} | {median:.1%} | {largest:.1%} |")
        worst = sorted((error, name) for name, error in errors.items() if error > ALLOWED)[::-1]
        listed.append(
            f"{path.name}: " + ", ".join(f"{name} {error:.0%}" for error, name in worst if not name.endswith(".R"))
        )
    print("\n" + "\n\n".join(listed))


if __name__ == "__main__":
    main()
