# SPDX-License-Identifier: GPL-3.0-or-later
"""Measuring the quality of a skin: Sinew beside Blender's own deformers, on one mesh, in the same poses."""
