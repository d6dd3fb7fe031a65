# SPDX-License-Identifier: GPL-3.0-or-later
"""Temporary objects on which poses are tried and meshes read; nothing of them stays."""
