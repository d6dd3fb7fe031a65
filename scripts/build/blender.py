"""Runs Python scripts in a Blender in which the built extension is installed.

The extension is installed from the zip, as a user installs it, once for each zip, into a separate user folder under .build.
The user's own Blender is not touched. Every run works on a private copy of that folder, because Blender removes an
extension's wheels from the folder when the extension is disabled, and every factory reset disables it.
"""

import os
import shutil
import signal
import subprocess
import tempfile
import time
from collections.abc import Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

from build import environment, extension
from build.console import Failure, step
from build.layout import BUILD, SCRIPTS
from build.once import building, fingerprint

INSTALLED = BUILD / "installed"
RUNNING = BUILD / "running"
ONE_DAY_S = 24 * 3600


def run(version: str, script: str | Path, args: Sequence[str] = (), *, env: Mapping[str, str] | None = None) -> int:
    """Runs a script in this Blender with the extension enabled; returns its exit code."""
    python, installed = environment.blender(version), install(version)
    with _private_copy(installed) as resources:
        command = [python, SCRIPTS / "build/inside_blender.py", script, *args]
        return _run_to_the_end(list(map(str, command)), blender_environment(resources) | dict(env or {}))


def install(version: str) -> Path:
    """The user folder in which the extension of the current sources is installed for this Blender."""
    with building():
        python, archive = environment.blender(version), extension.build(version)
        folder = INSTALLED / f"{version}-{fingerprint(BUILD, [archive], str(python.stat().st_mtime_ns))}"
        done = folder / "sinew.stamp"
        if not done.is_file():
            shutil.rmtree(folder, ignore_errors=True)
            with step(f"installing {archive.name} in Blender {version}"):
                command = [str(python), str(SCRIPTS / "build/install_in_blender.py"), str(archive)]
                env = blender_environment(folder)
                env.pop("PYTHONDONTWRITEBYTECODE", None)  # private copies of the folder include the compiled files
                result = subprocess.run(
                    command,
                    env=env,
                    text=True,
                    errors="replace",
                    stdout=subprocess.PIPE,
                    stderr=subprocess.STDOUT,
                )
                if result.returncode != 0:
                    raise Failure(f"Blender {version} did not install {archive}:\n{result.stdout.rstrip()}")
        done.touch()
        _remove_unused(INSTALLED, keep=folder)
        return folder


def blender_environment(resources: Path) -> dict[str, str]:
    """This process's environment variables, with Blender's user folder and without the user's Blender settings."""
    others = {key: value for key, value in os.environ.items() if not key.startswith("BLENDER_")}
    return others | {"BLENDER_USER_RESOURCES": str(resources)}


@contextmanager
def _private_copy(installed: Path):
    RUNNING.mkdir(parents=True, exist_ok=True)
    _remove_unused(RUNNING)
    private = Path(tempfile.mkdtemp(prefix=f"{installed.name}-", dir=RUNNING))
    try:
        shutil.copytree(installed, private, dirs_exist_ok=True)
        os.utime(private)
        yield private
    finally:
        shutil.rmtree(private, ignore_errors=True)


def _run_to_the_end(command: list[str], env: Mapping[str, str]) -> int:
    """Runs a command in the foreground and returns its exit code. A signal that ends this process also ends the command."""
    child = subprocess.Popen(command, env=env)
    previous = signal.signal(signal.SIGTERM, lambda *_: child.terminate())
    try:
        while True:
            try:
                code = child.wait()
                return code if code >= 0 else 128 - code  # ended by a signal: the exit code that a shell gives
            except KeyboardInterrupt:
                continue  # the terminal sent it to the child, too, and the child decides
    finally:
        signal.signal(signal.SIGTERM, previous)


def _remove_unused(folder: Path, keep: Path | None = None) -> None:
    """Removes folders that no process has used for a day."""
    for entry in folder.iterdir():
        stamp = entry / "sinew.stamp"
        used = (stamp if stamp.exists() else entry).stat().st_mtime
        if entry != keep and time.time() - used > ONE_DAY_S:
            shutil.rmtree(entry, ignore_errors=True)
