# SPDX-License-Identifier: GPL-3.0-or-later
"""Measure a skin under Sinew and under Blender's deformers: volume, stretch, inverted faces, self-intersections, bending."""

import argparse

import bpy

from ..errors import SinewError
from ..measure import report
from ..measure.measurement import Measurement, Settings
from ..scene import armature_modifier
from .blend_file import add_file_argument, choose_scene, object_named, open_file
from .frames import add_frame_arguments, range_of
from .output import Reporter


def add_arguments(parser: argparse.ArgumentParser):
    add_file_argument(parser)
    parser.add_argument("--object", metavar="NAME", required=True, help="the mesh")
    parser.add_argument("--scene", metavar="NAME", help="the scene (default: the current scene of the file)")
    parser.add_argument(
        "--poses",
        choices=["joints", "frames", "current"],
        default="joints",
        help="each joint turned by itself (default), the poses of frames, or the saved pose",
    )
    add_frame_arguments(parser)
    parser.add_argument(
        "--bone", metavar="NAME", action="append", help="measure only the joint at this bone's head; can be repeated"
    )
    parser.add_argument("--degrees", type=_degrees, default=90.0, help="the largest angle of each joint (default: 90)")
    parser.add_argument("--angles", type=_count, default=3, help="the number of steps to the largest angle (default: 3)")


def run(options: argparse.Namespace, reporter: Reporter) -> dict:
    """Measures. Returns all numbers and the report as text."""
    open_file(options.file, reporter)
    choose_scene(options.scene)
    skin, scene = object_named(options.object, "MESH", "mesh"), bpy.context.scene
    bones = armature_modifier.rig_of(skin).data.bones
    for name in options.bone or ():
        if name not in bones:
            raise SinewError(f"The armature of {skin.name} has no bone '{name}'")
    settings = Settings(
        poses=options.poses.upper(),
        frames=range_of(options, scene),
        bones=options.bone,
        degrees=options.degrees,
        steps=options.angles,
        axis="MUSCLES",
    )
    measurement = Measurement(skin, scene, settings)
    try:
        reporter.follow(measurement.steps(), f"measuring {skin.name}")
    finally:
        measurement.end()
    return {"verb": "measure", **report.numbers_of(measurement), "text": report.text_of(measurement)}


def _degrees(text: str) -> float:
    try:
        degrees = float(text)
    except ValueError:
        degrees = 0.0
    if not 1.0 <= degrees <= 179.0:
        raise argparse.ArgumentTypeError(f"'{text}' is not an angle from 1 to 179 degrees")
    return degrees


def _count(text: str) -> int:
    if not text.isdecimal() or not 1 <= int(text) <= 180:
        raise argparse.ArgumentTypeError(f"'{text}' is not a whole number from 1 to 180")
    return int(text)
