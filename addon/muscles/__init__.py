# SPDX-License-Identifier: GPL-3.0-or-later
"""Muscles and other tissues: adding, editing, mirroring, placing them under a skin, and saving them as text."""
