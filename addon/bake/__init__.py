# SPDX-License-Identifier: GPL-3.0-or-later
"""Keeping many frames, so that they play without Sinew."""
