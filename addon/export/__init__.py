# SPDX-License-Identifier: GPL-3.0-or-later
"""Exports characters: a copy of a character in which bones play the muscles, and files that keep the deformation."""
