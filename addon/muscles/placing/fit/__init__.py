# SPDX-License-Identifier: GPL-3.0-or-later
"""How thick a belly can be under the skin."""
