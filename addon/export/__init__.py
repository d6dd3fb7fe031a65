# SPDX-License-Identifier: GPL-3.0-or-later
"""What leaves Blender: a copy of a character in which muscles are bones, and files that keep its deformation."""
