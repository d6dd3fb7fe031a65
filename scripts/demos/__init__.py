"""What demo.py shows, inside Blender."""
