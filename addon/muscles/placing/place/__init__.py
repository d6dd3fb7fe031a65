# SPDX-License-Identifier: GPL-3.0-or-later
"""Where muscles go on a recognised body."""
