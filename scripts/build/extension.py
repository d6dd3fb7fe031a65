"""Assembles the extension that a user installs: .build/sinew-<version>-<platform>.zip.

usage: python3 scripts/build_extension.py    (prints the zip's path)

The zip holds addon/, farm/ (the scripts for render farms, see docs/farms.md), the wheel of the core, the licences, and the
manifest with two lines that depend on this machine: `wheels` and `platforms`. The same sources give the same bytes.
Blender's own validator checks the result.
"""

import io
import json
import tomllib
import zipfile
from pathlib import Path

from build import environment
from build import wheel as build_wheel
from build.build_lock import building, files_under, fingerprint, is_stamped
from build.console import run
from build.layout import BUILD, ROOT, blender_platform

ADDON = ROOT / "addon"
FARM = ROOT / "farm"
MANIFEST = "blender_manifest.toml"
LICENCES = ("LICENSE", "LICENSES-third-party.txt")
EPOCH = (1980, 1, 1, 0, 0, 0)


def build(version: str = environment.BLENDERS[0]) -> Path:
    """The zip of the current sources, validated by this Blender."""
    with building():
        wheels = [build_wheel.build()]
        manifest = (ADDON / MANIFEST).read_text(encoding="utf-8")
        about = tomllib.loads(manifest)
        target = BUILD / f"{about['id']}-{about['version']}-{blender_platform()}.zip"
        stamp, files = BUILD / "extension.stamp", [*files_under(ADDON), *files_under(FARM)]
        licences = [ROOT / name for name in LICENCES if (ROOT / name).is_file()]
        mark = fingerprint(ROOT, [*files, *licences, *wheels], target.name)
        if not (is_stamped(stamp, mark) and target.is_file()):
            stamp.unlink(missing_ok=True)
            for old in BUILD.glob(f"{about['id']}-*-{blender_platform()}.zip"):
                old.unlink()
            listed = [f"./wheels/{wheel.name}" for wheel in wheels]
            write(target, files, wheels, with_wheels(manifest, listed, [blender_platform()]))
            stamp.write_text(mark)
        validated = BUILD / f"extension-validated-{version}.stamp"
        if not is_stamped(validated, mark):
            validate(target, version)
            validated.write_text(mark)
        return target


def with_wheels(manifest: str, wheels: list[str], platforms: list[str]) -> str:
    """The manifest's text with its wheels and platforms. They come before the first table, as TOML requires."""
    lines = manifest.splitlines()
    first_table = next((i for i, line in enumerate(lines) if line.startswith("[")), len(lines))
    added = [f"platforms = {json.dumps(platforms)}", f"wheels = {json.dumps(wheels)}"]  # a JSON list is a TOML list
    return "\n".join([*lines[:first_table], *added, "", *lines[first_table:]]) + "\n"


def write(target: Path, files: list[Path], wheels: list[Path], manifest: str) -> None:
    """Writes the zip with sorted names and a constant date, so that equal contents give equal bytes."""
    content = {_name_in_zip(file): file.read_bytes() for file in files}
    content[MANIFEST] = manifest.encode()
    content |= {f"wheels/{wheel.name}": _stored(wheel) for wheel in wheels}
    content |= {name: (ROOT / name).read_bytes() for name in LICENCES if (ROOT / name).is_file()}
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(content):
            entry = zipfile.ZipInfo(name, EPOCH)
            entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
            archive.writestr(entry, content[name], compresslevel=9)


def _stored(wheel: Path) -> bytes:
    """The wheel with its files uncompressed: the zip compresses them better than maturin does."""
    packed = io.BytesIO()
    with zipfile.ZipFile(wheel) as source, zipfile.ZipFile(packed, "w", zipfile.ZIP_STORED) as target:
        for name in source.namelist():
            target.writestr(zipfile.ZipInfo(name, EPOCH), source.read(name))
    return packed.getvalue()


def _name_in_zip(file: Path) -> str:
    return file.relative_to(ADDON if file.is_relative_to(ADDON) else ROOT).as_posix()


def validate(target: Path, version: str) -> None:
    """Runs the validator of Blender's packager."""
    packager(version, "validate", target)


def packager(version: str, *arguments: str | Path) -> None:
    """Runs Blender's packager, a Python script inside bpy: what `blender --command extension` calls."""
    python = environment.blender(version)
    script = next(python.parent.parent.rglob("addons_core/bl_pkg/cli/blender_ext.py"))
    run([python, script, *arguments])
