# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender data: who belongs to whom, and the readers and writers of each kind of datum."""
