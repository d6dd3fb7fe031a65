# SPDX-License-Identifier: GPL-3.0-or-later
"""Correctives: shape keys that the angles of joints drive."""
