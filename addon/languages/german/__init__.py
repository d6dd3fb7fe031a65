# SPDX-License-Identifier: GPL-3.0-or-later
"""German texts of the user interface, by the English ones."""

from . import labels, messages, tooltips

TEXTS = {**messages.TEXTS, **tooltips.TEXTS, **labels.TEXTS}
