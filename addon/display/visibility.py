# SPDX-License-Identifier: GPL-3.0-or-later
"""Which tissues a rig's layers show.

What a layer hides is hidden as a person hides it with H, and put away: disabled in viewports, since Blender evaluates what is
merely hidden in every frame. An Empty with keys or drivers is only hidden: so hidden, Blender still evaluates these.
"""

from ..scene import tissue_empty

SHOW_OF_KIND = {"MUSCLE": "show_muscles", "BONE": "show_bones", "STUFFING": "show_stuffing", "SPHERE": "show_spheres"}


def shown_kinds(rig) -> frozenset[str]:
    """The kinds whose layers are on."""
    return frozenset(kind for kind, name in SHOW_OF_KIND.items() if getattr(rig.sinew, name))


def shown_as_empties(rig) -> frozenset[str]:
    """The kinds that Empties show."""
    return shown_kinds(rig) if rig.sinew.show_empties else frozenset()


def apply(rig, empties: list, view_layer):
    """Hides and shows the Empties of a rig's tissues and via points in a view layer as its layers say."""
    shown = shown_as_empties(rig)
    for empty in empties:
        # a via point is a handle of its muscle
        kind = "MUSCLE" if tissue_empty.is_via(empty) else empty.sinew.kind
        hidden = kind not in shown
        # asked first: it makes Blender sort objects that are new into the view layer
        if empty.hide_get(view_layer=view_layer) != hidden and view_layer.objects.get(empty.name) == empty:
            empty.hide_set(hidden, view_layer=view_layer)
        if hidden and not empty.animation_data:
            _put_away(empty)
        else:
            take_out(empty)


def _put_away(empty):
    """Disables an Empty in viewports, unless it is already: then a person did that, and it is theirs to undo."""
    if not empty.hide_viewport and empty.library is None:
        empty.hide_viewport = empty.sinew.is_put_away = True


def take_out(empty):
    """Enables an Empty in viewports that a layer put away."""
    if empty.sinew.is_put_away:
        empty.hide_viewport = empty.sinew.is_put_away = False
