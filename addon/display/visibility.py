# SPDX-License-Identifier: GPL-3.0-or-later
"""Shows and hides the Empties of tissues by kind, as the muscle layers of a rig say.

The Empties of a layer that is off are hidden, as with H, and disabled in viewports, because Blender evaluates hidden objects
in every frame. Keyed Empties are hidden, not disabled, so that Blender keeps evaluating them.
"""

from ..scene import tissue_empty

SHOW_OF_KIND = {"MUSCLE": "show_muscles", "BONE": "show_bones", "STUFFING": "show_stuffing", "SPHERE": "show_spheres"}


def shown_kinds(rig) -> frozenset[str]:
    """The kinds whose layers are on."""
    return frozenset(kind for kind, name in SHOW_OF_KIND.items() if getattr(rig.sinew.rig, name))


def shown_as_empties(rig) -> frozenset[str]:
    """The kinds of which Empties can be shown: one that is disabled in viewports is not."""
    settings = rig.sinew.rig
    return shown_kinds(rig) if settings.show_empties or settings.chosen else frozenset()


def apply(rig, empties: list, view_layer):
    """Hides or shows the Empties of a rig's tissues and via points in a view layer.

    While Empties are off, only the chosen tissue has one, with its via points.
    """
    settings = rig.sinew.rig
    kinds = shown_kinds(rig)
    for empty in empties:
        # a via point is a handle of its muscle
        tissue = empty.sinew.tissue.muscle if tissue_empty.is_via(empty) else empty
        kind = tissue.sinew.tissue.kind if tissue else "MUSCLE"
        is_chosen = tissue is not None and tissue.name == settings.chosen
        hidden = kind not in kinds or not (settings.show_empties or is_chosen)
        # hide_get comes first, because it makes Blender add new objects to the view layer
        if empty.hide_get(view_layer=view_layer) != hidden and view_layer.objects.get(empty.name) == empty:
            empty.hide_set(hidden, view_layer=view_layer)
        if hidden and not empty.animation_data:
            disable_for_layer(empty)
        else:
            enable_for_layer(empty)


def disable_for_layer(empty):
    """Disables an Empty in viewports. One that is already disabled was disabled by the user, and stays so."""
    if not empty.hide_viewport and empty.library is None:
        empty.hide_viewport = empty.sinew.tissue.disabled_by_layer = True


def enable_for_layer(empty):
    """Enables an Empty in viewports that a layer disabled."""
    if empty.sinew.tissue.disabled_by_layer:
        empty.hide_viewport = empty.sinew.tissue.disabled_by_layer = False
