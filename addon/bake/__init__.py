# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes that keep the deformed skin as shape keys, correctives or point caches, which play without Sinew."""
