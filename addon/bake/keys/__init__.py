# SPDX-License-Identifier: GPL-3.0-or-later
"""Shape keys: frames kept as keys with keyed values."""
