"""Installs an extension zip in the Blender that runs this script, as a user does.

usage: (a Python with bpy) install_in_blender.py ZIP

The user folder is that of BLENDER_USER_RESOURCES. The script checks that the extension can be enabled, but does not save the
preferences; inside_blender.py enables it in each process.
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
    sys.exit("The extension was installed but could not be enabled")
