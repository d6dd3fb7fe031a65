# SPDX-License-Identifier: GPL-3.0-or-later
"""The positions and sizes of muscles on a recognised body."""
