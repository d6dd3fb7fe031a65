# SPDX-License-Identifier: GPL-3.0-or-later
"""Muscles: made, edited, mirrored, placed under a skin, saved as text."""
