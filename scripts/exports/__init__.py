"""Comparing exported files with the skin in Blender."""
