"""Installs an extension zip as a user does, in the Blender that runs this.

usage: (a Python with bpy) install_in_blender.py ZIP

The user folder is the one that BLENDER_USER_RESOURCES names. Nothing is enabled for later: whoever runs a script
with the extension enables it (inside_blender.py); that it can be enabled is what the installation proves.
"""

import sys
from pathlib import Path

import bpy

archive = str(Path(sys.argv[1]).resolve())
try:
    result = bpy.ops.extensions.package_install_files(filepath=archive, repo="user_default", enable_on_install=True)
except RuntimeError as error:
    sys.exit(f"{error}")
if result != {"FINISHED"}:
    sys.exit(f"package_install_files returned {result}")
if "bl_ext.user_default.sinew" not in bpy.context.preferences.addons:
    sys.exit("the extension was installed, and could not be enabled")
