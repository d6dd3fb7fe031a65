# SPDX-License-Identifier: GPL-3.0-or-later
"""Measuring the quality of a deformed skin: Sinew and Blender's deformers, on one mesh, in the same poses."""
