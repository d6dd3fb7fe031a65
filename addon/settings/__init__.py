# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings that a person makes, kept in Blender's own data."""
