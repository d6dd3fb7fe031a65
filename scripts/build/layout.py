"""Where things lie in the repository, and what the machine below it is called."""

import platform
import sys
from pathlib import Path

if sys.version_info < (3, 11):
    sys.exit(f"Sinew's scripts need Python 3.11 or newer; this is {sys.version.split()[0]} ({sys.executable})")

ROOT = Path(__file__).resolve().parents[2]
SCRIPTS = ROOT / "scripts"
BUILD = ROOT / ".build"
ON_WINDOWS = sys.platform == "win32"

_SYSTEMS = {"linux": "linux", "darwin": "macos", "win32": "windows"}
_MACHINES = {"x86_64": "x64", "amd64": "x64", "aarch64": "arm64", "arm64": "arm64"}


def blender_platform() -> str:
    """This machine as a Blender manifest names it, such as `linux-x64`."""
    machine = platform.machine().lower()
    return f"{_SYSTEMS.get(sys.platform, sys.platform)}-{_MACHINES.get(machine, machine)}"
