"""Writes docs/settings.md: every setting with its label, its meaning, its unit and its name in Sinew 0.1.

usage: python3 scripts/run_in_blender.py scripts/build/settings_page.py
"""

from pathlib import Path

from bl_ext.user_default.sinew.settings import (
    bone_settings,
    goal_settings,
    growth_settings,
    old_names,
    rig_settings,
    skin_settings,
    tissue_settings,
)

PAGE = Path(__file__).resolve().parents[2] / "docs" / "settings.md"
ABOUT = """# Settings

Scripts, keyframes and drivers reach every setting by these names. `object` is the object that owns the setting. A group
such as `object.sinew.skin` is created when a script reads it. To find out whether an object has one without creating it,
use `object.is_property_set("sinew") and object.sinew.is_property_set("skin")`.

The names of Sinew 0.1 are in the last column if they changed. In 0.1, all settings of an object were in `object.sinew`.
Python scripts can still use the old names. Each warns once (`DeprecationWarning`) and names the new path.

Settings with *yes* in the column Animated can be keyed, driven, and animated in the NLA. Viewport, renders, bakes and the
command line use the value that Blender evaluates at their frame. The same is true of the location, rotation, scale and
display size of the Empties. Blender does not evaluate an Empty that is disabled, or whose collection is excluded or
disabled. Its keys still act, but its drivers and NLA strips do not; the **Sinew** panel then says so.

`python3 scripts/run_in_blender.py scripts/build/settings_page.py` writes this page.
"""
MIGRATION = """
## Files of Sinew 0.1

When a file is opened, or data is appended or linked, Sinew moves settings, painted data (`sinew_rest_distance` becomes
`sinew_slack`), and the paths in keyframes, NLA strips, drivers and keying sets to their new names. From then on,
`object.sinew.version` is 2. Musculature files of Sinew 0.1 can be loaded. New ones have the new names and
`"sinew_musculature": 2`.

Linked data is migrated in memory in every session, because its file can't be written. The **Sinew** panel names each
library that should be opened and saved once with this version. Settings that a shot overrides are kept.

What is not taken over:

- wraps that a shot of Sinew 0.1 added to a linked muscle or removed from it, and the muscle of a via point that a shot
  changed: the shot shows what its library has
- node trees and modifiers of the user that name the attribute or vertex group `sinew_rest_distance`
- a layout call of another add-on such as `layout.prop(object.sinew, "gain")`: it shows a hidden property without effect
- drivers that are added by an old path after the file was opened: they are migrated when it is opened the next time
- the choice `rest_distance` of the operator Paint Region, which is now `slack`
"""
OWNERS = (
    ("Tissues and via points: `object.sinew.tissue`", tissue_settings.SinewTissueSettings, "tissue.", old_names.OF_OBJECTS),
    ("Skins: `object.sinew.skin`", skin_settings.SinewSkinSettings, "skin.", old_names.OF_OBJECTS),
    ("Grown skins: `object.sinew.skin.growth`", growth_settings.SinewGrowthSettings, "skin.growth.", {}),
    ("Baked shape keys: `object.sinew.skin.baked_keys[...]`", skin_settings.SinewBakedKey, "", old_names.OF_BAKED_KEYS),
    ("Armatures: `object.sinew.rig`", rig_settings.SinewRigSettings, "rig.", old_names.OF_OBJECTS),
    ("Goals: `object.sinew.goal`", goal_settings.SinewGoalSettings, "goal.", {}),
    ("Bones: `pose_bone.sinew`", bone_settings.SinewBoneSettings, "", old_names.OF_BONES),
)
ANIMATED_TYPES = {"BOOLEAN", "INT", "FLOAT", "ENUM"}
UNITS = {"LENGTH": "m", "ROTATION": "rad"}


def text() -> str:
    """The page as Markdown."""
    parts = [ABOUT]
    for heading, settings, path, names in OWNERS:
        old_of = {new: old for old, new in names.items()}
        rows = [
            _row(known, old_of.get(path + known.identifier, ""))
            for known in settings.bl_rna.properties
            # old names are stored as hidden properties of their own; every group of Blender has a name
            if known.identifier != "rna_type"
            and not known.description.startswith("Unique name used")
            and (not known.is_hidden or path + known.identifier in old_of)
        ]
        table = "\n".join(("| Name | Label | Meaning | Unit | Animated | In 0.1 |", "|---|---|---|---|---|---|", *rows))
        parts.append(f"## {heading}\n\n{table}\n")
    return "\n".join(parts) + MIGRATION


def _row(known, old: str) -> str:
    meaning = known.description
    if known.type == "ENUM":
        items = "; ".join(f"`{item.identifier}` ({item.name}): {item.description}" for item in known.enum_items)
        meaning = f"{meaning}. {items}"
    is_renamed = old and old != known.identifier
    can_be_animated = known.is_animatable and not known.is_readonly and known.type in ANIMATED_TYPES
    cells = (
        f"`{known.identifier}`",
        known.name,
        meaning,
        UNITS.get(known.unit, ""),
        "yes" if can_be_animated else "",
        f"`{old}`" if is_renamed else "",
    )
    return f"| {' | '.join(cell.replace('|', '/') for cell in cells)} |"


if __name__ == "__main__":
    PAGE.write_text(text(), encoding="utf-8")
