"""Draws figures of docs/mathematics; figure_mathematics.py starts it.

Each function named draw_X writes docs/mathematics/X.svg. It prints the numbers that the pages quote from the figure.
"""

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
sys.path.append(str(Path(__file__).parents[2]))

from pictures.mathematics import baking, binding, correction, growing, muscles, reach, relaxation, skinning

PAGES = (muscles, binding, skinning, relaxation, correction, reach, growing, baking)


def main() -> int:
    matplotlib.rcParams.update(
        {
            "svg.fonttype": "none",
            "svg.hashsalt": "sinew",
            "font.size": 9,
            "font.family": "sans-serif",
            "font.sans-serif": ["Helvetica", "Arial", "DejaVu Sans"],
            "path.simplify_threshold": 0.3,
        }
    )
    drawings = {
        name.removeprefix("draw_"): draw for page in PAGES for name, draw in vars(page).items() if name.startswith("draw_")
    }
    unknown = set(sys.argv[1:]) - drawings.keys()
    if unknown:
        print(f"no figure {', '.join(sorted(unknown))}; there are {', '.join(drawings)}", file=sys.stderr)
        return 2
    for name, draw in drawings.items():
        if name in sys.argv[1:] or len(sys.argv) == 1:
            draw()
    return 0


if __name__ == "__main__":
    sys.exit(main())
