# SPDX-License-Identifier: GPL-3.0-or-later
"""Items of enumerations that choose joints."""

CROSSED = ("CROSSED", "All that Muscles Cross", "The joint at the head of each bone that a muscle moves against its parent")
SELECTED = ("SELECTED", "Selected Bones", "The joint at the head of each bone that is selected in Pose Mode")
