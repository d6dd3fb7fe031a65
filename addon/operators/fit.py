# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.fit` fits tissues under the skin (docs/mathematics/fitting.md, Fit under the skin)."""

from bpy.types import Operator

from ..errors import SinewError
from ..muscles.placing.fit import fit
from ..muscles.placing.fit.skin_surface import SkinSurface
from ..scene import characters, tissue_empty
from ..scene.linked_data import writable
from ..skin.main_skin import skins_to_fit
from .base import SinewOperator, rig_of_context


class SINEW_OT_fit(SinewOperator, Operator):
    """Resize the selected tissues, or all tissues of the armature, so that they end just under the skin in the rest pose"""

    bl_idname, bl_label = "sinew.fit", "Fit under Skin"
    needs_tissues = True

    def run(self, context):
        rig = writable(rig_of_context(context))
        skins = skins_to_fit(rig)
        if not skins:
            raise SinewError(f"{rig.name} has no mesh with faces to fit under. Parent a mesh to it (Ctrl+P) and try again")
        tissues = characters.tissues_of(rig)
        if not tissues:
            raise SinewError(f"{rig.name} has no muscles. Add some with Add Preset or Add Tissue")
        chosen = [empty for empty in tissues if empty.select_get()] or tissues
        surface = SkinSurface.of_all(skins, rig)
        problems, readable = {}, []
        for empty in chosen:
            try:
                readable.append((empty, tissue_empty.read(empty, rig)))
            except SinewError as error:
                problems[empty.name] = str(error)
        fitted = fit.fit_all([shape for _, shape in readable], surface)
        for (empty, _), shape in zip(readable, fitted):
            tissue_empty.write(empty, shape)
        self.warn(problems)
        return f"{len(fitted)} tissues fitted under {', '.join(skin.name for skin in skins)}"
