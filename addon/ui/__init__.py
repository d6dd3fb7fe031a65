# SPDX-License-Identifier: GPL-3.0-or-later
"""What a person sees: the panel in the sidebar of the 3D viewport."""
