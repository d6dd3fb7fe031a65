# SPDX-License-Identifier: GPL-3.0-or-later
"""Files on disk: atomic writes, file names, and strict reading of JSON."""
