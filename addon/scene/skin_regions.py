# SPDX-License-Identifier: GPL-3.0-or-later
"""The settings of a skin that vary by region (Wilhelms 1997): names, labels and descriptions.

The value at a vertex is the setting of the mesh, times the factors of the bones by their weights at the vertex, times the
factor that is painted there.
"""

from dataclasses import dataclass

PAINTED_PREFIX = "sinew_"


@dataclass(frozen=True)
class Parameter:
    """One setting. name: of the factor of a bone, and of the mesh's setting if it has one (`of_mesh`).

    former_name: the name in Sinew 0.1, or an empty text.
    """

    name: str
    label: str
    description: str
    of_mesh: bool = True
    former_name: str = ""

    @property
    def painted(self) -> str:
        """The name of the vertex group or float attribute that holds the painted factors."""
        return PAINTED_PREFIX + self.name

    @property
    def painted_names(self) -> tuple[str, ...]:
        """The name to write, then the name that Sinew 0.1 wrote, if it was another."""
        return (self.painted, PAINTED_PREFIX + self.former_name) if self.former_name else (self.painted,)


PARAMETERS = (
    Parameter(
        "anchor_stiffness",
        "Anchor Stiffness",
        "Pull towards the skinned position. 0: only held by neighboring skin",
    ),
    Parameter(
        "edge_stiffness",
        "Edge Stiffness",
        "How strongly skin keeps its own shape against the motion of bones and muscles",
    ),
    Parameter(
        "slack",
        "Slack",
        "Distance the skin may drift from its skinned position before it is pulled back",
        former_name="rest_distance",
    ),
    Parameter(
        "relaxation",
        "Relaxation",
        "Fraction of the iterations that relax the skin. 0: the skin stays where bones and muscles move it",
        of_mesh=False,
    ),
    Parameter(
        "muscle_influence",
        "Muscle Influence",
        "How strongly the skin shows the swelling of muscles. 1 is true to scale",
    ),
    Parameter(
        "fat_sliding",
        "Fat Sliding",
        "How freely skin slides along itself over the tissue below. 0: not at all. 1: freely",
    ),
)
# strengths, 0 to 1, of the constraints on the joint at a bone's head and on its skin
JOINT_STRENGTHS = ("keep_volume", "crease", "contact")
OF_BONE = (*(parameter.name for parameter in PARAMETERS), *JOINT_STRENGTHS)
# factors of a bone that count when a skin is grown, and not in a frame
OF_GROWTH = ("fat_thickness",)


def parameter_of(name: str) -> Parameter:
    """The parameter with this name."""
    return next(parameter for parameter in PARAMETERS if parameter.name == name)
