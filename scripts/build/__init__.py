"""Building: the Python environments, the wheel, the extension's zip, and Blender with the extension."""
