# SPDX-License-Identifier: GPL-3.0-or-later
"""The problems of a character, each with the button that repairs it."""

from dataclasses import dataclass

from ..display import views
from ..live import session
from ..operators.repair import label_of
from ..scene import correction_modifier
from ..settings import updates
from .sidebar import label_wrapped

MOST_PROBLEMS = 5
# Solid viewports colored like this show the translucent material of X-ray
_COLORS_OF_MATERIALS = ("MATERIAL", "TEXTURE")


@dataclass(frozen=True)
class Problem:
    """A problem. repair: what `sinew.repair` does about it, or an empty text. name: the object to repair."""

    text: str
    repair: str = ""
    name: str = ""
    icon: str = "ERROR"


def of(context, rig, character) -> list[Problem]:
    """The problems of a character in its current state."""
    found = []
    if not updates.is_enabled():
        found.append(Problem("Sinew is turned off in the preferences", "ENABLE", rig.name, "INFO"))
    if rig.mode == "EDIT":
        found.append(Problem("Muscles are not shown in Edit Mode", "LEAVE_EDIT_MODE", rig.name, "INFO"))
    if character is None:
        return found
    if character.skins and rig.data.pose_position == "REST":
        found.append(Problem("The armature shows its rest pose", "SHOW_POSE", rig.name, "INFO"))
    if _hides_xray(context, rig):
        found.append(Problem("The colors of this viewport hide X-ray", "MATERIAL_COLORS", rig.name, "INFO"))
    for key in character.skins:
        skin = key.find()
        if skin:
            found += _of_skin(skin)
    state = session.cached_rig(rig)
    if state:
        found += [Problem(text, "SELECT_TISSUE", name) for name, text in state.problems.items()]
    return found


def draw(layout, problems: list[Problem]):
    """Draws the first problems, each with its button."""
    for problem in problems[:MOST_PROBLEMS]:
        label_wrapped(layout, problem.text, problem.icon)
        if problem.repair:
            repair = layout.operator("sinew.repair", text=label_of(problem.repair), icon="TOOL_SETTINGS")
            repair.what, repair.name = problem.repair, problem.name
    if len(problems) > MOST_PROBLEMS:
        label_wrapped(layout, f"{len(problems) - MOST_PROBLEMS} more are marked in the list", "ERROR")


def _of_skin(skin) -> list[Problem]:
    reason = session.reason(skin)
    if reason:
        if correction_modifier.modifier_of(skin) is None:
            return [Problem(reason, "BIND_AGAIN", skin.name)]
        return [Problem(reason, "SINGLE_USER" if skin.data.users > 1 else "", skin.name)]
    if not skin.sinew.skin.live:
        return [Problem(f"{skin.name}: Live is off", "LIVE", skin.name, "INFO")]
    return []


def _hides_xray(context, rig) -> bool:
    space = context.space_data
    if views.of(rig) != views.XRAY or space is None or space.type != "VIEW_3D":
        return False
    return space.shading.type == "SOLID" and space.shading.color_type not in _COLORS_OF_MATERIALS
