# SPDX-License-Identifier: GPL-3.0-or-later
"""A musculature as a text file: tissues relative to their bones, so that they fit another character, and skin settings.

Lengths are fractions: of the bone's length for positions, of the tissue's length for widths and tendons. They are rounded
to a grid that Blender's float32 can represent (4 µm on a person), so that loading and saving a file gives the same bytes.
A file is data: nothing in it is executed. Error messages name the file, the line and the field.
"""
