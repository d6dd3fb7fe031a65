# SPDX-License-Identifier: GPL-3.0-or-later
"""Which bones of a rig are which parts of the body."""
