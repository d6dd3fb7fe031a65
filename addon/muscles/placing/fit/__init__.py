# SPDX-License-Identifier: GPL-3.0-or-later
"""Fits tissues under the skin, with the Rust core."""
