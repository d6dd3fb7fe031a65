# SPDX-License-Identifier: GPL-3.0-or-later
"""Temporary objects in which bakes, exports and measurements try poses and read meshes; they are removed afterwards."""
