"""The folders of the repository, and the name of this machine's platform."""

import platform
import sys
from pathlib import Path

if sys.version_info < (3, 11):  # noqa: UP036 - for people who start a script with an older Python
    sys.exit(f"Sinew's scripts need Python 3.11 or newer; this is {sys.version.split()[0]} ({sys.executable})")

ROOT = Path(__file__).resolve().parents[2]
SCRIPTS = ROOT / "scripts"
BUILD = ROOT / ".build"
ON_WINDOWS = sys.platform == "win32"

_SYSTEMS = {"linux": "linux", "darwin": "macos", "win32": "windows"}
_MACHINES = {"x86_64": "x64", "amd64": "x64", "aarch64": "arm64", "arm64": "arm64"}


def blender_platform() -> str:
    """This machine's platform in the spelling of a Blender manifest, such as `linux-x64`."""
    machine = platform.machine().lower()
    return f"{_SYSTEMS.get(sys.platform, sys.platform)}-{_MACHINES.get(machine, machine)}"
