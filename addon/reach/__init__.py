# SPDX-License-Identifier: GPL-3.0-or-later
"""Reaching: a rig's bones as joints with limits, goals for them, and the poses that meet those. The core computes."""
