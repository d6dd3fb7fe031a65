# SPDX-License-Identifier: GPL-3.0-or-later
"""Point caches: files with the positions of all vertices in all frames, baked whole or in chunks."""
