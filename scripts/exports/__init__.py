"""Exported files held against what Blender showed."""
