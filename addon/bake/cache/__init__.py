# SPDX-License-Identifier: GPL-3.0-or-later
"""Point caches: files of skin positions, baked whole or in chunks."""
