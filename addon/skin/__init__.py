# SPDX-License-Identifier: GPL-3.0-or-later
"""Skins: bound to the muscles, grown over them, carried over to a new surface."""
