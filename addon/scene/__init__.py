# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender data: which objects are a character, and the readers and writers of each kind of datum."""
