# SPDX-License-Identifier: GPL-3.0-or-later
"""What of a character is seen: Empties by kind, shaded ellipsoids coloured by stretch, attachment lines."""
