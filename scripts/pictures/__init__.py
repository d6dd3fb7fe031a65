"""Pictures of the documentation, made inside Blender."""
