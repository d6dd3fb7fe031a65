# SPDX-License-Identifier: GPL-3.0-or-later
"""Baked shape keys: how they are stored in a mesh, and bakes of frames to keys with animated values."""
