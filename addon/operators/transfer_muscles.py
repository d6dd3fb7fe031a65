# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.transfer_muscles` copies the tissues of another character, by matched skins."""

from bpy.types import Operator

from ..errors import SinewError
from ..muscles import edit, portable_names
from ..muscles.placing.fit import fit
from ..muscles.placing.fit.skin_surface import SkinSurface
from ..muscles.placing.place.correspondence import SkinnedBody, carried
from ..muscles.placing.recognise import segments
from ..scene import characters, tissue_empty
from ..scene.linked_data import writable
from ..skin.main_skin import skins_to_fit
from .base import SinewOperator, rig_of_context
from .tissue_options import FIT_SKIN


class SINEW_OT_transfer_muscles(SinewOperator, Operator):
    """Copy the tissues of the other selected character: each keeps its place between bone and skin of the active one"""

    bl_idname, bl_label = "sinew.transfer_muscles", "Transfer Muscles"

    fit_skin: FIT_SKIN

    def run(self, context):
        rig = writable(rig_of_context(context))
        source = self._source(context, rig)
        named = portable_names.of_rig(source)
        if not named:
            raise SinewError(f"{source.name} has no muscles to transfer")
        problems: dict[str, str] = {}
        shapes = [portable_names.with_portable_names(tissue_empty.read(empty, source), named) for empty in named.values()]
        target = _skinned(rig)
        shapes = carried(shapes, _skinned(source), target, problems)
        if not shapes:
            raise SinewError(f"No muscle of {source.name} has a counterpart on {rig.name}: {next(iter(problems.values()))}")
        if self.fit_skin and target.skin:
            shapes = fit.fit_all(shapes, target.skin)
        edit.add(rig, shapes)
        self.warn(problems)
        return f"{len(shapes)} tissues transferred from {source.name} to {rig.name}"

    def _source(self, context, rig):
        """The other selected armature, or the armature of another selected mesh."""
        for found in context.selected_objects:
            other = found if found.type == "ARMATURE" else characters.rig_or_none(found) if found.type == "MESH" else None
            if other not in (None, rig):
                return other
        raise SinewError(f"Select the character with muscles, then Shift-click {rig.name}, so that it is active")


def _skinned(rig) -> SkinnedBody:
    skins = skins_to_fit(rig)
    return SkinnedBody(segments.recognise(rig), SkinSurface.of_all(skins, rig) if skins else None)
