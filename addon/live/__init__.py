# SPDX-License-Identifier: GPL-3.0-or-later
"""What happens in a frame, and what is cached between frames."""
