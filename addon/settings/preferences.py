# SPDX-License-Identifier: GPL-3.0-or-later
"""Sinew's preferences: the main switch, threads, colors, confirmations, and the log."""

import bpy
import _sinew
from bpy.props import BoolProperty, EnumProperty, FloatVectorProperty, IntProperty, StringProperty
from bpy.types import AddonPreferences

from ..display import anatomy_colours, translucent_skin
from ..files import log
from ..files.user_folder import PACKAGE
from . import skin_settings, updates

MOST_THREADS = 256
# settings of a skin whose values for new skins are preferences
_QUALITY = ("iterations", "render_iterations", "viewport_detail", "render_detail")
LEVELS = (
    ("ERROR", "Errors", "Only errors"),
    ("WARNING", "Warnings", "Errors and warnings"),
    ("INFO", "Information", "Also what operators did"),
    ("DEBUG", "Everything", "Also details for developers"),
)


def _enabled_changed(preferences, _context):
    updates.set_enabled(preferences.is_enabled)


def _threads_changed(preferences, _context):
    _sinew.set_thread_count(preferences.threads)


def _colours_changed(preferences, _context):
    for number, name in COLOUR_OF_NUMBER.items():
        anatomy_colours.set_colour(number, tuple(getattr(preferences, name)))
    translucent_skin.set_colour(tuple(preferences.skin_colour))


def _log_changed(preferences, _context):
    log.set_level(preferences.log_level)
    preferences.log_problem = ""
    try:
        log.write_to(bpy.path.abspath(preferences.log_file) if preferences.log_file else "")
    except OSError as error:
        preferences.log_problem = f"The log can't be written: {error.strerror}. Choose another file"


def _colour(name: str, description: str, default: tuple, size: int = 3):
    return FloatVectorProperty(
        name=name,
        description=description,
        subtype="COLOR",
        size=size,
        min=0.0,
        max=1.0,
        default=default,
        update=_colours_changed,
    )


COLOUR_OF_NUMBER = {
    anatomy_colours.BELLY: "belly_colour",
    anatomy_colours.TENDON: "tendon_colour",
    anatomy_colours.BONE: "bone_colour",
    anatomy_colours.STUFFING: "stuffing_colour",
    anatomy_colours.SPHERE: "sphere_colour",
    anatomy_colours.CHOSEN: "chosen_colour",
}


class SinewPreferences(AddonPreferences):
    bl_idname = PACKAGE

    is_enabled: BoolProperty(
        name="Sinew Is On",
        description="Deform skins and show muscles. Off: all characters look as they do without Sinew",
        default=True,
        update=_enabled_changed,
    )
    threads: IntProperty(
        name="Threads",
        description="Number of processor threads for muscles and skin. 0: one per core. Results do not depend on it",
        min=0,
        max=MOST_THREADS,
        default=0,
        update=_threads_changed,
    )
    shows_first: BoolProperty(
        name="Show New Muscles as X-ray",
        description="The first muscles of a character switch its view to X-ray",
        default=True,
    )
    confirms_remove: BoolProperty(
        name="Confirm Remove Sinew", description="Ask before all of Sinew is removed from a character", default=True
    )
    new_iterations: IntProperty(
        name="Iterations",
        description="Iterations of the relaxation of skins that are bound from now on",
        min=0,
        max=100,
        soft_max=20,
        default=10,
    )
    new_render_iterations: IntProperty(
        name="Render Iterations",
        description="The same in renders and bakes. 0: as many as in the viewport",
        min=0,
        max=100,
        soft_max=20,
        default=0,
    )
    new_viewport_detail: EnumProperty(
        name="Viewport Detail",
        description="How much is computed in the viewport, of skins that are bound from now on",
        items=skin_settings.DETAILS,
        default="FULL",
    )
    new_render_detail: EnumProperty(
        name="Render Detail",
        description="How much is computed in renders, of skins that are bound from now on",
        items=skin_settings.DETAILS,
        default="FULL",
    )
    belly_colour: _colour("Bellies", "Color of the bellies of muscles", anatomy_colours.DEFAULTS[anatomy_colours.BELLY])
    tendon_colour: _colour("Tendons", "Color of tendons", anatomy_colours.DEFAULTS[anatomy_colours.TENDON])
    bone_colour: _colour("Bones", "Color of bone tissues", anatomy_colours.DEFAULTS[anatomy_colours.BONE])
    stuffing_colour: _colour("Stuffing", "Color of stuffing", anatomy_colours.DEFAULTS[anatomy_colours.STUFFING])
    sphere_colour: _colour("Spheres", "Color of joint spheres", anatomy_colours.DEFAULTS[anatomy_colours.SPHERE])
    chosen_colour: _colour("Chosen", "Color of the chosen tissue", anatomy_colours.DEFAULTS[anatomy_colours.CHOSEN])
    skin_colour: _colour("X-ray Skin", "Color and opacity of the skin in the view X-ray", translucent_skin.DEFAULT, size=4)
    log_level: EnumProperty(
        name="Log", description="Which messages the log keeps", items=LEVELS, default="WARNING", update=_log_changed
    )
    log_file: StringProperty(
        name="Log File",
        description="A file that the log is also written to. Empty: none",
        subtype="FILE_PATH",
        update=_log_changed,
    )
    log_problem: StringProperty(name="Log Problem", description="Why the log file can't be written", options={"HIDDEN"})

    def draw(self, _context):
        layout = self.layout
        layout.use_property_split = True
        column = layout.column(heading="General")
        for name in ("is_enabled", "shows_first", "confirms_remove", "threads"):
            column.prop(self, name)
        column = layout.column(heading="Quality of New Skins")
        for name in _QUALITY:
            column.prop(self, f"new_{name}")
        column = layout.column(heading="Colors")
        for name in (*COLOUR_OF_NUMBER.values(), "skin_colour"):
            column.prop(self, name)
        column = layout.column(heading="Log")
        column.prop(self, "log_level")
        column.prop(self, "log_file")
        if self.log_problem:
            column.label(text=self.log_problem, icon="ERROR")


CLASSES = (SinewPreferences,)


def current():
    """The preferences, or None where the extension is registered without being enabled, as in a test of a part."""
    addon = bpy.context.preferences.addons.get(PACKAGE)
    return addon.preferences if addon else None


def set_quality(skin):
    """Gives a mesh that was bound for the first time the quality of new skins. A setting that somebody made stays."""
    preferences = current()
    settings = skin.sinew.skin
    for name in _QUALITY if preferences else ():
        value = getattr(preferences, f"new_{name}")
        if value != getattr(settings, name) and not settings.is_property_set(name):
            setattr(settings, name, value)


def apply():
    """Applies the stored preferences when the extension is enabled."""
    preferences = current()
    if preferences is None:
        return
    for changed in (_threads_changed, _colours_changed, _log_changed, _enabled_changed):
        changed(preferences, bpy.context)
