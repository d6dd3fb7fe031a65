"""Makes the zips of a release: one for each platform, checked and validated, in .build/release.

usage: python3 scripts/release.py [--tag TAG] [--wheels DIR] [--only-check | --only-wheel] [--channel DIR] [--notes FILE]

Without --wheels, it builds the portable wheel of this machine. DIR holds wheels of several platforms, built by --only-wheel
on machines of each. The files are checked: the version is the same in the manifest, in Cargo.toml, in CITATION.cff and in
CHANGELOG.md (with --tag, also in the tag, and the changelog has a date); a Linux wheel needs glibc 2.28 at most; a Windows
wheel imports only libraries that every Windows has; a zip has 2 MB at most; and Blender's validator accepts it. --channel
copies the zips into a folder and writes the index for Blender's Get Extensions > Repositories there. --notes writes the
changelog's text about this version. --only-check checks the version, and stops.
"""

import argparse
import shutil
import sys
import tomllib
import zipfile
from pathlib import Path

from build import binaries, environment, extension, versions
from build import wheel as build_wheel
from build.build_lock import files_under
from build.console import Failure, say
from build.layout import BUILD, ROOT, blender_platform_of_wheel

RELEASE = BUILD / "release"
MOST_BYTES = 2_000_000


def make(wheel: Path, folder: Path) -> Path:
    """Writes and checks the zip of one platform; returns its path."""
    platform = blender_platform_of_wheel(wheel.name)
    say(f"{wheel.name}: {check_wheel(wheel)}")
    manifest = (extension.ADDON / extension.MANIFEST).read_text(encoding="utf-8")
    about = tomllib.loads(manifest)
    target = folder / f"{about['id']}-{about['version']}-{platform.replace('-', '_')}.zip"
    files = [*files_under(extension.ADDON), *files_under(extension.FARM)]
    extension.write(target, files, [wheel], extension.with_wheels(manifest, [f"./wheels/{wheel.name}"], [platform]))
    if target.stat().st_size > MOST_BYTES:
        raise Failure(f"{target.name} has {target.stat().st_size:,} bytes, and the largest allowed is {MOST_BYTES:,}")
    for version in environment.BLENDERS:
        extension.validate(target, version)
    return target


def check_wheel(wheel: Path) -> str:
    """Says what the wheel's compiled module requires. Raises Failure if that is too much, or if there is no module."""
    with zipfile.ZipFile(wheel) as archive:
        modules = [name for name in archive.namelist() if name.endswith((".so", ".pyd"))]
        if len(modules) != 1:
            raise Failure(f"{wheel.name} should hold one compiled module and holds {len(modules)}")
        return binaries.check(modules[0], archive.read(modules[0]), build_wheel.OLDEST_GLIBC)


def publish(zips: list[Path], channel: Path) -> None:
    """Puts zips into the folder of a channel, in place of those of the same platform, and writes its index.json."""
    channel.mkdir(parents=True, exist_ok=True)
    for made in zips:
        platform = made.stem.rsplit("-", 1)[1]
        for old in channel.glob(f"*-{platform}.zip"):
            old.unlink()
        shutil.copy(made, channel)
    extension.packager(environment.BLENDERS[0], "server-generate", f"--repo-dir={channel}")


def main() -> None:
    parser = argparse.ArgumentParser(description="Makes and checks the zips of a release.")
    parser.add_argument("--tag", help="also check that this tag, such as v1.0.0, may be released")
    parser.add_argument("--wheels", type=Path, metavar="DIR", help="take the wheels in this folder")
    only = parser.add_mutually_exclusive_group()
    only.add_argument("--only-check", action="store_true", help="check the version, and stop")
    only.add_argument("--only-wheel", action="store_true", help="build and check this machine's wheel, and stop")
    parser.add_argument("--notes", type=Path, metavar="FILE", help="write the notes of this version")
    parser.add_argument("--channel", type=Path, metavar="DIR", help="also publish into this folder")
    wanted = parser.parse_args()
    try:
        problems = versions.release_problems(wanted.tag) if wanted.tag else versions.disagreements()
        if problems:
            raise Failure("\n".join(problems))
        if wanted.notes:
            wanted.notes.write_text(versions.notes() + "\n", encoding="utf-8")
        if wanted.only_check:
            return
        wheels = sorted(wanted.wheels.glob("*.whl")) if wanted.wheels else [build_wheel.build_portable()]
        if not wheels:
            raise Failure(f"{wanted.wheels} holds no wheels")
        if wanted.only_wheel:
            for wheel in wheels:
                say(f"{wheel.name}: {check_wheel(wheel)}")
                print(wheel)
            return
        shutil.rmtree(RELEASE, ignore_errors=True)
        RELEASE.mkdir(parents=True)
        zips = [make(wheel, RELEASE) for wheel in wheels]
        if wanted.channel:
            publish(zips, wanted.channel)
    except Failure as error:
        sys.exit(f"sinew: {error}")
    for made in zips:
        print(f"{made.relative_to(ROOT)} {made.stat().st_size:,} bytes")


if __name__ == "__main__":
    main()
