# SPDX-License-Identifier: GPL-3.0-or-later
"""A musculature as a text file: tissues told from their bones, so that they fit another character, and the skin's settings.

Lengths are fractions: of a bone for the place of a point, of the tissue's own length for its widths and tendons. They
are rounded to a grid that Blender's own precision can hold (4 µm on a man), so that saving what was loaded gives the
same bytes. A file is data: nothing in it is run, and what is wrong with it is told by file, line and field.
"""
