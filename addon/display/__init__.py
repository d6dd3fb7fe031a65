# SPDX-License-Identifier: GPL-3.0-or-later
"""Which tissues are shown, and how: Empties by kind, shaded ellipsoids, colors of stretch, and times of a frame."""
