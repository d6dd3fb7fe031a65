# SPDX-License-Identifier: GPL-3.0-or-later
"""The skin settings that differ from region to region (Wilhelms 1997): their names, labels and meanings.

The value at a vertex is the value of the mesh, times the factors of the bones that have weights there, times the painted
factor.
"""

from dataclasses import dataclass

PAINTED_PREFIX = "sinew_"


@dataclass(frozen=True)
class Parameter:
    """One setting. name: of the bones' factor. of_mesh: of the mesh's setting that the factors multiply, or "" for 1."""

    name: str
    label: str
    description: str
    of_mesh: str = ""

    @property
    def painted(self) -> str:
        """The name of the vertex group or float attribute with the painted factor."""
        return PAINTED_PREFIX + self.name


PARAMETERS = (
    Parameter(
        "anchor_stiffness",
        "Anchor Stiffness",
        "Pull towards the skinned position. 0: only held by neighboring skin",
        "anchor_stiffness",
    ),
    Parameter(
        "edge_stiffness",
        "Edge Stiffness",
        "How strongly skin keeps its own shape",
        "edge_stiffness",
    ),
    Parameter(
        "rest_distance",
        "Slack",
        "Distance the skin may drift from its skinned position before it is pulled back",
        "rest_distance",
    ),
    Parameter(
        "relaxation",
        "Relaxation",
        "Fraction of the iterations that relax the skin. 0: the skin stays at its skinned position",
    ),
    Parameter("muscle_influence", "Muscle Influence", "How strongly the skin shows the swelling of muscles", "gain"),
    Parameter(
        "fat_sliding",
        "Fat Sliding",
        "How freely the skin slides over the tissue below. 0: not at all, 1: freely",
        "fat_sliding",
    ),
)
# strengths of the constraints at the joint at a bone's head, 0..1
JOINT_STRENGTHS = ("keep_volume", "crease", "contact")
OF_BONE = (*(parameter.name for parameter in PARAMETERS), *JOINT_STRENGTHS)


def parameter_of(name: str) -> Parameter:
    """The parameter with this name."""
    return next(parameter for parameter in PARAMETERS if parameter.name == name)
