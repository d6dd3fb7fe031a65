"""What is measured, inside Blender."""
