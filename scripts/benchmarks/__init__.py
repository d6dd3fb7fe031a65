"""Measurements inside Blender: frames, quality, bakes, growing and reaching."""
