"""The Python environments, the wheel, the extension's zip, and Blender with it."""
