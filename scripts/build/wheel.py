"""Builds the Python wheel of the Rust core, rust/py, into .build/wheels.

One wheel works in every Python from 3.11 (abi3). It is built again only if the Rust sources changed.
"""

import os
import shutil
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from build import environment
from build.build_lock import building, files_under, fingerprint, is_stamped
from build.console import Failure, run, step
from build.layout import BUILD, ROOT

WHEELS = BUILD / "wheels"
PORTABLE = BUILD / "portable-wheels"
OLDEST_GLIBC = (2, 28)
RUST_MISSING = "cargo was not found. Sinew's core is written in Rust. Install it from https://rustup.rs and run this again."


def build() -> Path:
    """The wheel of the current sources."""
    with building():
        mark = fingerprint(ROOT, _sources())
        stamp = WHEELS / "sinew.stamp"
        if not is_stamped(stamp, mark):
            _build_into(WHEELS, [], os.environ)
            stamp.write_text(mark)
        return only_wheel(WHEELS)


def build_portable() -> Path:
    """The wheel of the current sources for other machines of this system. On Linux it needs glibc 2.28 or newer.

    glibc 2.28 is that of the VFX Reference Platform CY2024. zig links against it, whatever glibc this machine has.
    """
    with building():
        mark = fingerprint(ROOT, [*_sources(), environment.LOCKS / "zig.txt"], "portable")
        stamp = PORTABLE / "sinew.stamp"
        if not is_stamped(stamp, mark):
            options, env = [], dict(os.environ)
            if sys.platform == "linux":
                options = ["--zig", "--compatibility", f"manylinux_{OLDEST_GLIBC[0]}_{OLDEST_GLIBC[1]}"]
                env["PATH"] = (
                    f"{environment.zig().parent}{os.pathsep}{env.get('PATH', '')}"  # maturin looks for ziglang there
                )
            _build_into(PORTABLE, options, env)
            stamp.write_text(mark)
        return only_wheel(PORTABLE)


def only_wheel(folder: Path) -> Path:
    found = list(folder.glob("*.whl"))
    if len(found) != 1:
        raise Failure(f"{folder} should hold one wheel and holds {len(found)}. Remove the folder and run this again")
    return found[0]


def _sources() -> list[Path]:
    """The files that the wheel is made from: those of the workspace, and rust/ without tests and benchmarks."""
    workspace = [ROOT / name for name in ("Cargo.toml", "Cargo.lock", "rust-toolchain.toml", ".cargo/config.toml")]
    return [file for file in workspace if file.is_file()] + files_under(ROOT / "rust", {"tests", "benches", "target"})


def _build_into(folder: Path, options: Sequence[str], env: Mapping[str, str]) -> None:
    if not (ROOT / "rust/py/Cargo.toml").is_file():
        raise Failure("rust/py/Cargo.toml is missing: this folder is not a complete copy of Sinew")
    if shutil.which("cargo") is None:
        raise Failure(RUST_MISSING)
    python = environment.tools()
    shutil.rmtree(folder, ignore_errors=True)
    locked = ["--locked"] if (ROOT / "Cargo.lock").is_file() else []
    with step("building the Rust core (a minute the first time)"):
        run(
            [
                environment.program(python, "maturin"),
                "build",
                "--release",
                *locked,
                *options,
                "--interpreter",
                python,
                "--manifest-path",
                ROOT / "rust/py/Cargo.toml",
                "--out",
                folder,
            ],
            cwd=ROOT,
            # apart from the target folder of cargo, so that neither waits for the other
            env=dict(env) | {"CARGO_TARGET_DIR": str(BUILD / "target")},
        )
