"""Makes the Python environments under .build: the tools, the style checkers, and one for each Blender as a Python module.

`tools` is a plain virtual environment with uv and maturin. uv finds or fetches the Python that each bpy needs and fills an
environment from scripts/locks. A second run changes nothing and takes no time.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

from build.build_lock import building, fingerprint, is_stamped
from build.console import Failure, PythonMissing, run, step
from build.layout import BUILD, ON_WINDOWS, ROOT, SCRIPTS

PYTHON_OF_BLENDER = {"5.2": "3.13", "4.5": "3.11"}
BLENDERS = tuple(PYTHON_OF_BLENDER)
LOCKS = SCRIPTS / "locks"


def tools() -> Path:
    """The Python of the environment that holds uv and maturin."""
    return _ready("tools", "any Python", _fill_tools)


def style() -> Path:
    """The Python of the environment that holds ruff and mypy.

    It has no stubs of bpy. Those of fake-bpy-module turn every `bpy.context.scene` into an optional value, which gave 700
    reports about code that is right. Without stubs, bpy's values have any type, and mypy checks our own modules.
    """
    return _ready("style", "any Python", _fill_tools)


def dask() -> Path:
    """The Python of the environment for tests of the Dask launcher, with the Dask that farm/dask/requirements.txt pins."""
    return _ready("dask", "any Python", _fill_tools, ROOT / "farm/dask/requirements.txt")


def zig() -> Path:
    """The Python of the environment with the compiler zig. It is 400 MB, so only a release makes it."""
    return _ready("zig", "any Python", _fill_with_uv)


def docs() -> Path:
    """The Python of the environment that builds the documentation's site, and checks CI files and forms by their schemas."""
    return _ready("docs", "any Python", _fill_with_uv)


def blender(version: str) -> Path:
    """The Python that can `import bpy` of this Blender version."""
    if version not in PYTHON_OF_BLENDER:
        raise Failure(f"Blender {version} is not supported. Choose one of {', '.join(BLENDERS)}")
    return _ready(f"blender-{version}", PYTHON_OF_BLENDER[version], _fill_blender)


def program(python: Path, name: str) -> Path:
    """The path of a command that is installed in the environment of this Python."""
    return python.with_name(f"{name}.exe" if ON_WINDOWS else name)


def _ready(name: str, python_version: str, fill, lock: Path | None = None) -> Path:
    lock, home = lock or LOCKS / f"{name}.txt", BUILD / name
    python = home / ("Scripts/python.exe" if ON_WINDOWS else "bin/python")
    stamp, mark = home / "sinew.stamp", fingerprint(lock.parent, [lock], python_version)
    if is_stamped(stamp, mark) and python.exists():
        return python
    with building():
        if not (is_stamped(stamp, mark) and python.exists()):
            shutil.rmtree(home, ignore_errors=True)
            fill(name, python_version, home, lock, python)
            stamp.write_text(mark)
    return python


def _fill_tools(name: str, _python_version: str, home: Path, lock: Path, python: Path) -> None:
    with step(f"making .build/{name}: {', '.join(_wanted(lock))}"):
        try:
            run([sys.executable, "-m", "venv", home])
        except Failure as error:
            raise Failure(
                f"{error}\nThis Python cannot make virtual environments; on Debian and Ubuntu install python3-venv."
            ) from error
        run([python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "-r", lock])


def _fill_with_uv(name: str, _python_version: str, home: Path, lock: Path, python: Path) -> None:
    uv, env = program(tools(), "uv"), uv_environment("")
    with step(f"making .build/{name}: {', '.join(_wanted(lock))}"):
        run([uv, "venv", "--quiet", "--python", sys.executable, home], env=env)
        run([uv, "pip", "install", "--quiet", "--no-build", "--python", python, "-r", lock], env=env)


def _fill_blender(name: str, python_version: str, home: Path, lock: Path, python: Path) -> None:
    uv, env = program(tools(), "uv"), uv_environment(python_version)
    base_python = _find_or_fetch_python(uv, env, name, python_version)
    with step(f"making .build/{name} with Python {python_version}: {', '.join(_wanted(lock))}"):
        run([uv, "venv", "--quiet", "--python", base_python, home], env=env)
        # compiled once: if PYTHONDONTWRITEBYTECODE is set, each process would compile bpy's scripts again, which takes 2 s
        run([uv, "pip", "install", "--quiet", "--no-build", "--compile-bytecode", "--python", python, "-r", lock], env=env)


def _find_or_fetch_python(uv: Path, env: dict[str, str], name: str, version: str) -> str:
    find = [str(uv), "python", "find", "--no-python-downloads", version]
    found = subprocess.run(find, env=env, text=True, capture_output=True)
    if found.returncode == 0:
        return found.stdout.strip()
    try:
        with step(f"fetching Python {version} for .build/{name} (none found here)"):
            run([uv, "python", "install", "--no-progress", "--no-bin", version], env=env)
            return subprocess.run(find, env=env, text=True, capture_output=True, check=True).stdout.strip()
    except (Failure, subprocess.CalledProcessError) as error:
        raise PythonMissing(
            f"{name} needs Python {version}: none was found and none could be fetched.\n"
            f"Install Python {version} (python.org, `pyenv install {version}`, or your system's package "
            f"python{version}) so that python{version} is on the PATH, and run this again.\n{error}"
        ) from error


def uv_environment(python_version: str) -> dict[str, str]:
    """The environment variables for uv: the system's certificates, and pyenv's Pythons instead of its shims."""
    env = dict(os.environ, UV_SYSTEM_CERTS="1", UV_NATIVE_TLS="1", UV_NO_CONFIG="1")
    env.pop("VIRTUAL_ENV", None)
    pyenv = Path(env.get("PYENV_ROOT", Path.home() / ".pyenv"))
    bins = sorted(pyenv.glob(f"versions/{python_version}.*/bin"), reverse=True)
    path = [part for part in env.get("PATH", "").split(os.pathsep) if Path(part) != pyenv / "shims"]
    return env | {"PATH": os.pathsep.join([*map(str, bins), *path])}


def _wanted(lock: Path) -> list[str]:
    """The packages that a lock file was made for: the names and versions in its heading, or all packages."""
    lines = lock.read_text().splitlines()
    heading = [line.lstrip("# ") for line in lines if line.startswith("#   ")]
    return heading or [line for line in lines if line and not line.startswith("#")]
