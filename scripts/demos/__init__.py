"""The demos of demo.py, inside Blender."""
