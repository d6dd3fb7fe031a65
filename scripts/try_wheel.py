"""Tests a wheel in another Python or with another numpy: imports it and runs tests/core.

usage: python3 scripts/try_wheel.py [--wheel FILE] [--python 3.12] [--numpy 1.26.4] [--only-import]

Without --wheel it is the portable wheel of these sources. uv finds or fetches the Python, and fills a temporary environment
with the wheel, numpy, pytest and hypothesis, in the versions of scripts/locks where numpy allows it.
"""

import argparse
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from build import environment
from build import wheel as build_wheel
from build.console import Failure, run, say
from build.layout import ON_WINDOWS, ROOT

IMPORT = """import sys, numpy, _sinew
print(f"_sinew {_sinew.__version__}, Python {sys.version.split()[0]}, numpy {numpy.__version__}")
"""


def pinned(*names: str) -> list[str]:
    """Requirements in the versions that the newest Blender's environment has."""
    lock = (environment.LOCKS / f"blender-{environment.BLENDERS[0]}.txt").read_text(encoding="utf-8")
    return [found for found in re.findall(r"(?m)^[\w-]+==\S+", lock) if found.partition("==")[0] in names]


def main() -> int:
    parser = argparse.ArgumentParser(description="Tests a wheel in another Python or with another numpy.")
    parser.add_argument("--wheel", type=Path, metavar="FILE", help="the wheel (the portable wheel of these sources)")
    parser.add_argument("--python", default="3.11", metavar="VERSION", help="the Python (3.11)")
    parser.add_argument("--numpy", metavar="VERSION", help="the numpy (the newest for this Python)")
    parser.add_argument("--only-import", action="store_true", help="only import it")
    wanted = parser.parse_args()
    try:
        wheel = wanted.wheel.resolve() if wanted.wheel else build_wheel.build_portable()
        uv = environment.program(environment.tools(), "uv")
        with tempfile.TemporaryDirectory() as folder:
            python = Path(folder, "Scripts/python.exe" if ON_WINDOWS else "bin/python")
            env = environment.uv_environment(wanted.python)
            run([uv, "venv", "--quiet", "--python", wanted.python, folder], env=env)
            numpy = f"numpy=={wanted.numpy}" if wanted.numpy else "numpy"
            tools = [] if wanted.only_import else pinned("pytest", "hypothesis")
            run(
                [uv, "pip", "install", "--quiet", "--only-binary", ":all:", "--python", python, wheel, numpy, *tools],
                env=env,
            )
            say(subprocess.run([python, "-c", IMPORT], capture_output=True, text=True, check=True).stdout.strip())
            if wanted.only_import:
                return 0
            options = ["-q", "--strict-markers", "-o", "markers=slow: slow", "-m", "not slow", "-p", "no:cacheprovider"]
            return subprocess.run([python, "-m", "pytest", "tests/core", "--rootdir", ROOT, *options], cwd=ROOT).returncode
    except Failure as error:
        print(f"sinew: {error}", file=sys.stderr)
    except subprocess.CalledProcessError as error:
        print(f"sinew: the wheel cannot be imported:\n{error.stderr}", file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main())
