# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.muscle_volumes` lists the volume that each muscle has, beside the measured one."""

import bpy
from bpy.props import EnumProperty
from bpy.types import Operator

from ..errors import SinewError
from ..live import session
from ..muscles import portable_names
from ..muscles.placing.fit.skin_surface import SkinSurface
from ..muscles.placing.place import preset_file
from ..muscles.placing.place.figure import FIGURES, measured_volumes
from ..scene import characters
from ..skin.main_skin import skins_to_fit
from .base import SinewOperator, rig_of_context
from .tissue_options import FIGURE

TEXT = "Muscle Volumes"
CM3_OF_M3 = 1e6
CLOSE = (0.8, 1.25)  # volume over the measured one, from which a muscle counts as having it


def _preset_items(_self, _context):
    return [item for item in preset_file.available() if preset_file.read(item[0]).fills]


class SINEW_OT_muscle_volumes(SinewOperator, Operator):
    """List the volume of each muscle beside the measured one, scaled to the body, as a text in the Text Editor"""

    bl_idname, bl_label = "sinew.muscle_volumes", "Muscle Volumes"
    needs_tissues = True

    preset: EnumProperty(name="Preset", description="The preset that has the measured volumes", items=_preset_items)
    figure: FIGURE

    def run(self, context):
        rig = rig_of_context(context)
        skins = skins_to_fit(rig)
        if not skins:
            raise SinewError(f"{rig.name} has no mesh with faces, so the volume of its body is not known")
        body_m3 = SkinSurface.of_all(skins, rig).core.volume
        measured_m3 = measured_volumes(preset_file.read(self.preset), body_m3, FIGURES[self.figure])
        rows = []
        for name, volume_m3 in sorted(_volumes(rig).items()):
            wanted_m3 = measured_m3.get(portable_names.without_side(name), 0.0)
            if wanted_m3:
                rows.append((name, CM3_OF_M3 * volume_m3, CM3_OF_M3 * wanted_m3, volume_m3 / wanted_m3))
        if not rows:
            raise SinewError(f"{rig.name} has no muscle of the preset {self.preset}. Add it with Add Preset")
        close = sum(CLOSE[0] <= ratio <= CLOSE[1] for *_row, ratio in rows)
        lines = [f"Volumes of muscles, cm3, in a body of {1000 * body_m3:.1f} l", ""]
        lines += [f"{'muscle':45}{'has':>8}{'measured':>10}{'ratio':>7}"]
        lines += [f"{name:45}{has:8.1f}{wanted:10.1f}{ratio:7.2f}" for name, has, wanted, ratio in rows]
        text = bpy.data.texts.get(TEXT) or bpy.data.texts.new(TEXT)
        text.from_string("\n".join(lines) + "\n")
        shares = " to ".join(f"{limit:g}" for limit in CLOSE)
        return f"{close} of {len(rows)} muscles have {shares} of their measured volume; all are in the text '{TEXT}'"


def _volumes(rig) -> dict[str, float]:
    """By portable name: the volume of each tissue at rest, m3."""
    state = session.cached_rig(rig)
    if state is None or state.musculature is None:
        raise SinewError(f"The tissues of {rig.name} are not usable. See the problems in the Sinew panel")
    posed = state.musculature.pose(state.pose, state.tension, state.posed)
    tissues = characters.tissues_of(rig)
    names = {empty: name for name, empty in portable_names.of_rig(rig).items()}
    solved = [tissues[index] for index in state.solved]
    return {names[empty]: volume for empty, volume in zip(solved, posed.volume.tolist())}
