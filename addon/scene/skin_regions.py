# SPDX-License-Identifier: GPL-3.0-or-later
"""The settings of a skin that differ from region to region (Wilhelms 1997): their names and meanings, said once.

At a vertex each is the mesh's own value, times the factors of the bones that weigh there, times what is painted there.
"""

from dataclasses import dataclass

PAINTED_PREFIX = "sinew_"


@dataclass(frozen=True)
class Parameter:
    """One setting. name: of the bones' factor. of_mesh: of the mesh's own setting, which the factors multiply; "" for 1."""

    name: str
    label: str
    description: str
    of_mesh: str = ""

    @property
    def painted(self) -> str:
        """The name of the vertex group or float attribute that holds it."""
        return PAINTED_PREFIX + self.name


PARAMETERS = (
    Parameter(
        "anchor_stiffness",
        "Anchor Stiffness",
        "How firmly skin holds on to where bones and muscles bring it; 0 lets it go wherever the skin around it pulls",
        "anchor_stiffness",
    ),
    Parameter(
        "edge_stiffness",
        "Edge Stiffness",
        "How firmly skin keeps its own shape against what bones and muscles do to it",
        "edge_stiffness",
    ),
    Parameter(
        "rest_distance",
        "Rest Distance",
        "Slack: how far skin may lie from where bones and muscles bring it before it is pulled there",
        "rest_distance",
    ),
    Parameter(
        "relaxation", "Relaxation", "Share of the iterations that relax the skin; 0 leaves it as bones and muscles bring it"
    ),
    Parameter("muscle_influence", "Muscle Influence", "How strongly the swelling of muscles shows on the skin", "gain"),
    Parameter(
        "fat_sliding",
        "Fat Sliding",
        "How freely skin slides along itself over what lies beneath: 0 not at all, 1 freely",
        "fat_sliding",
    ),
)
# of a bone, the joint at its head and its skin: how fully each acts, 0..1
JOINT_STRENGTHS = ("keep_volume", "crease", "contact")
OF_BONE = (*(parameter.name for parameter in PARAMETERS), *JOINT_STRENGTHS)


def parameter_of(name: str) -> Parameter:
    """The parameter of this name."""
    return next(parameter for parameter in PARAMETERS if parameter.name == name)
