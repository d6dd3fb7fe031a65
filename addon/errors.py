# SPDX-License-Identifier: GPL-3.0-or-later
"""The one error that the add-on raises on purpose."""


class SinewError(Exception):
    """Something the user asked for can't be done; the text names the thing, its value and what to do about it.

    Raised where the fault is found, caught once in the operator, which reports it (DESIGN: errors). Never raised
    through a handler: `evaluate` keeps it as the reason that the panel shows.
    """
