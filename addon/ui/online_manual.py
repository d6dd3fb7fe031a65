# SPDX-License-Identifier: GPL-3.0-or-later
"""The pages of the documentation that *Online Manual* in the context menu of a button opens.

The manifest's `website` is the address of the site. Without it, nothing is registered, and Blender opens its own manual.
"""

import re
import tomllib
from pathlib import Path

import bpy

_MANIFEST = Path(__file__).resolve().parents[1] / "blender_manifest.toml"
# headings of docs/settings.md, without the path of the settings that is part of them
_SETTINGS = {
    "SinewTissueSettings": "Tissues and via points: `object.sinew.tissue`",
    "SinewSkinSettings": "Skins: `object.sinew.skin`",
    "SinewGrowthSettings": "Grown skins: `object.sinew.skin.growth`",
    "SinewBakedKey": "Baked shape keys: `object.sinew.skin.baked_keys[...]`",
    "SinewRigSettings": "Armatures: `object.sinew.rig`",
    "SinewGoalSettings": "Goals: `object.sinew.goal`",
    "SinewBoneSettings": "Bones: `pose_bone.sinew`",
}


def website() -> str:
    """The address of the documentation's site, with a slash at its end, or an empty text if the manifest has none."""
    with open(_MANIFEST, "rb") as file:
        address = tomllib.load(file).get("website", "")
    return address.rstrip("/") + "/" if address else ""


def pages() -> tuple[tuple[str, str], ...]:
    """(pattern, page) pairs: patterns of Blender's names in lower case, and pages below the site's address."""
    operators = [(f"bpy.ops.sinew.{name}*", f"operators.html#{_anchor(f'sinew.{name}')}") for name in dir(bpy.ops.sinew)]
    settings = [(f"bpy.types.{kind.lower()}.*", f"settings.html#{_anchor(heading)}") for kind, heading in _SETTINGS.items()]
    # a longer pattern first: Blender takes the first that matches, and add_goal* would match add_goal_more, too
    return (*sorted(operators, key=lambda pair: -len(pair[0])), *settings)


def manual_map():
    """What Blender calls to find a page."""
    return website(), pages()


def _anchor(heading: str) -> str:
    """The anchor of a heading, as MkDocs makes it."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-")


def register():
    if website():
        bpy.utils.register_manual_map(manual_map)


def unregister():
    if website():
        bpy.utils.unregister_manual_map(manual_map)
