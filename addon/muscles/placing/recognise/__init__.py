# SPDX-License-Identifier: GPL-3.0-or-later
"""Which bone is which part of the body."""
