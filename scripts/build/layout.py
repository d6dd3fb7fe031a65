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
_WHEEL_SYSTEMS = {"linux": "linux", "manylinux": "linux", "macosx": "macos", "win": "windows"}
_MACHINES = {"x86_64": "x64", "amd64": "x64", "aarch64": "arm64", "arm64": "arm64"}


def blender_platform() -> str:
    """This machine's platform in the spelling of a Blender manifest, such as `linux-x64`."""
    machine = platform.machine().lower()
    return f"{_SYSTEMS.get(sys.platform, sys.platform)}-{_MACHINES.get(machine, machine)}"


def blender_platform_of_wheel(name: str) -> str:
    """The platform of a wheel, from its file name, in the spelling of a Blender manifest."""
    tag = name.removesuffix(".whl").rsplit("-", 1)[-1]
    system = next((system for word, system in _WHEEL_SYSTEMS.items() if tag.startswith(word)), None)
    machine = next((machine for word, machine in _MACHINES.items() if tag.endswith(word)), None)
    if not (name.endswith(".whl") and system and machine):
        raise ValueError(f"{name} is not a wheel for Linux, macOS or Windows")
    return f"{system}-{machine}"
