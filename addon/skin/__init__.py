# SPDX-License-Identifier: GPL-3.0-or-later
"""Skins: binding meshes to tissues, growing new skins, and transferring data to a new surface."""
