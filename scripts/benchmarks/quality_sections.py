"""Draws sections: a cut through a bent joint, perpendicular to its axis, for each deformer side by side."""

from pathlib import Path

import matplotlib
import numpy as np
from matplotlib import pyplot
from matplotlib.collections import LineCollection

from benchmarks import quality_poses
from benchmarks.quality_character import SINEW, Character

SECTIONS = (("elbow", 120), ("elbow", 150), ("knee", 140), ("hip", 110), ("shoulder", 135))
SHOWN_RADII = 1.7  # around the joint
DOTS_PER_INCH = 70
REST_COLOUR, SKIN_COLOUR, SINEW_COLOUR = "0.8", "0.15", "tab:red"


def draw(character: Character, target: Path) -> None:
    """Writes the picture: a row for each joint and angle, a column for each deformer, with the rest pose in grey."""
    matplotlib.use("Agg")
    names = tuple(character.shown)
    figure, grid = pyplot.subplots(
        len(SECTIONS), len(names), figsize=(3 * len(names), 3 * len(SECTIONS)), layout="constrained"
    )
    for row, (joint, degrees) in zip(grid, SECTIONS, strict=True):
        side_view = SideView(character, f"{joint}.L")
        character.pose({f"{joint}.L": degrees})
        for axes, name in zip(row, names, strict=True):
            axes.add_collection(LineCollection(side_view.cut(character.rest), colors=REST_COLOUR, linewidths=1.0))
            colour = SINEW_COLOUR if name == SINEW else SKIN_COLOUR
            axes.add_collection(LineCollection(side_view.cut(character.points(name)), colors=colour, linewidths=1.4))
            axes.set_title(f"{joint} {degrees}°, {name}", fontsize=10)
            axes.set_xlim(-side_view.shown_m, side_view.shown_m)
            axes.set_ylim(-side_view.shown_m, side_view.shown_m)
            axes.set_aspect("equal")
            axes.set_xticks([])
            axes.set_yticks([])
    figure.savefig(target, dpi=DOTS_PER_INCH)
    pyplot.close(figure)


class SideView:
    """The plane through a joint, perpendicular to its axis.

    The limb above the joint points up. At hip and shoulder, the body's up points up.
    """

    def __init__(self, character: Character, joint: str):
        hinge = quality_poses.hinge_of(character.rig, joint)
        bone = character.rig.data.bones[hinge.bone]
        self.joint, self.axis = np.array(bone.head_local), np.array(hinge.axis.normalized())
        on_trunk = joint.startswith(("hip", "shoulder"))
        up = np.array((0.0, 0.0, 1.0) if on_trunk else bone.parent.head_local - bone.head_local)
        up -= self.axis * (up @ self.axis)
        self.up = up / np.linalg.norm(up)
        self.right = np.cross(self.axis, self.up)
        self.shown_m = SHOWN_RADII * quality_poses.radius_of(character.rig, joint)
        self.triangles = character.triangles

    def cut(self, points: np.ndarray) -> np.ndarray:
        """(lines, 2, 2): the lines in which the plane cuts the skin near the joint, as right and up in m."""
        from_joint = points.astype(np.float64) - self.joint
        height = from_joint @ self.axis
        flat = np.stack([from_joint @ self.right, from_joint @ self.up], axis=1)
        near = (np.linalg.norm(from_joint[self.triangles], axis=2) < 2.0 * self.shown_m).all(axis=1)
        above = height[self.triangles] > 0.0
        corners = self.triangles[near & above.any(axis=1) & ~above.all(axis=1)]
        lines = []
        for triangle in corners:
            ends = []
            for a, b in zip(triangle, np.roll(triangle, -1), strict=True):
                if (height[a] > 0.0) != (height[b] > 0.0):
                    t = height[a] / (height[a] - height[b])
                    ends.append(flat[a] + t * (flat[b] - flat[a]))
            lines.append(ends)
        return np.array(lines).reshape(-1, 2, 2)
