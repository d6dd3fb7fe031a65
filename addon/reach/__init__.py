# SPDX-License-Identifier: GPL-3.0-or-later
"""Reaching (inverse kinematics): bones as joints with limits, goals, dragging and baking. The solver is in the core."""
