"""What a release requires: one version everywhere, wheels that old machines can load, small zips, and licences."""

import shutil
import struct
import sys
import tomllib
import zipfile

import pytest
import release
import third_party
from build import binaries, environment, versions
from build import wheel as build_wheel
from build.console import Failure
from build.layout import ROOT, blender_platform_of_wheel
from build.wheel import OLDEST_GLIBC


def pe(imports=(), delayed=()):
    """The bytes of a 64-bit PE file with one section that imports these libraries."""
    base, offset = 0x1000, 0x200
    names, content = {}, bytearray(0x400)
    end = 0x200  # the names follow the two tables
    for name in (*imports, *delayed):
        names[name] = base + end
        content[end : end + len(name) + 1] = name.encode() + b"\0"
        end += len(name) + 1
    for row, name in enumerate(imports):
        struct.pack_into("<5I", content, 20 * row, 1, 0, 0, names[name], 1)
    for row, name in enumerate(delayed):
        struct.pack_into("<8I", content, 0x100 + 32 * row, 1, names[name], 0, 0, 0, 0, 0, 0)
    header = bytearray(offset)
    header[:2], header[0x80:0x84] = b"MZ", b"PE\0\0"
    struct.pack_into("<I", header, 0x3C, 0x80)
    struct.pack_into("<HH", header, 0x84, 0x8664, 1)  # machine, number of sections
    struct.pack_into("<H", header, 0x94, 240)  # size of the optional header
    struct.pack_into("<H", header, 0x98, 0x20B)
    directory = 0x98 + 112
    struct.pack_into("<II", header, directory + 8, base, 20 * (len(imports) + 1))
    if delayed:
        struct.pack_into("<II", header, directory + 8 * 13, base + 0x100, 32 * (len(delayed) + 1))
    struct.pack_into("<8sIIII", header, 0x98 + 240, b".idata", len(content), base, len(content), offset)
    return bytes(header + content)


def test_the_import_table_of_a_pe_file_is_read():
    assert binaries.libraries_of(pe(["KERNEL32.dll", "python3.dll"], ["ws2_32.dll"])) == [
        "kernel32.dll",
        "python3.dll",
        "ws2_32.dll",
    ]
    assert binaries.libraries_of(pe()) == []


def test_a_real_windows_program_is_read():
    programs = list((environment.tools().parents[1]).rglob("pip/_vendor/distlib/t64.exe"))
    if not programs:
        pytest.skip("NOT TESTED: this pip brings no Windows programs")
    libraries = binaries.libraries_of(programs[0].read_bytes())
    assert "kernel32.dll" in libraries and all(name.endswith(".dll") for name in libraries)


@pytest.mark.parametrize("content", [b"", b"\x7fELF", b"MZ" + bytes(200), pe()[:0x90] + b"\0" * 400])
def test_what_is_not_a_pe_file_is_refused(content):
    with pytest.raises((Failure, struct.error)):
        binaries.libraries_of(content)


def test_a_windows_module_imports_only_what_every_windows_has():
    allowed = ["api-ms-win-crt-math-l1-1-0.dll", "bcryptprimitives.dll", "kernel32.dll", "python3.dll", "VCRUNTIME140.dll"]
    assert "python3.dll" in binaries.check("_sinew/_sinew.pyd", pe(allowed), OLDEST_GLIBC)
    with pytest.raises(Failure, match=r"libgcc_s_seh-1\.dll"):
        binaries.check("_sinew/_sinew.pyd", pe([*allowed, "libgcc_s_seh-1.dll"]), OLDEST_GLIBC)
    with pytest.raises(Failure, match=r"python311\.dll"):  # that would bind it to one Python
        binaries.check("_sinew/_sinew.pyd", pe([*allowed, "python311.dll"]), OLDEST_GLIBC)


def test_the_newest_glibc_counts():
    elf = b"\x7fELF...GLIBC_2.2.5\0GLIBC_2.28\0GLIBC_2.9\0"
    assert binaries.glibc_of(elf) == (2, 28)
    assert "2.28" in binaries.check("_sinew/_sinew.abi3.so", elf, (2, 28))
    with pytest.raises(Failure, match=r"needs glibc 2\.35, and the oldest supported is 2\.28"):
        binaries.check("_sinew/_sinew.abi3.so", elf + b"GLIBC_2.35\0", (2, 28))


@pytest.mark.parametrize(
    ("tag", "platform"),
    [
        ("manylinux_2_28_x86_64", "linux-x64"),
        ("manylinux_2_28_aarch64", "linux-arm64"),
        ("win_amd64", "windows-x64"),
        ("macosx_11_0_arm64", "macos-arm64"),
        ("macosx_10_12_x86_64", "macos-x64"),
    ],
)
def test_the_platform_of_a_wheel(tag, platform):
    assert blender_platform_of_wheel(f"sinew-1.0.0-cp311-abi3-{tag}.whl") == platform


def test_a_file_for_no_platform_is_refused():
    with pytest.raises(ValueError, match="not a wheel"):
        blender_platform_of_wheel("sinew-1.0.0-py3-none-any.whl")


@pytest.fixture
def sources(tmp_path):
    """A copy of the files that state the version, all with version 1.2.3 and a date."""
    (tmp_path / "addon").mkdir()
    for name in (versions.MANIFEST, "Cargo.toml", "CITATION.cff"):
        text = (ROOT / name).read_text(encoding="utf-8")
        (tmp_path / name).write_text(text.replace(versions.of_manifest(), "1.2.3"), encoding="utf-8")
    (tmp_path / "CHANGELOG.md").write_text(
        "# Changes\n\n## 1.2.3 - 2026-12-01\n\nNew.\n\n## 1.2.2 - 2026-11-01\n\nOld.\n", encoding="utf-8"
    )
    return tmp_path


def test_the_versions_agree_today():
    assert versions.disagreements() == []
    assert versions.notes()


def test_a_tag_with_one_version_and_a_date_may_be_released(sources):
    assert versions.release_problems("v1.2.3", sources) == []
    assert versions.notes(sources) == "New."


@pytest.mark.parametrize(
    ("file", "old", "new", "problem"),
    [
        ("Cargo.toml", "1.2.3", "1.2.4", "Cargo.toml has 1.2.4"),
        ("CITATION.cff", "version: 1.2.3", "version: 1.2.2", "CITATION.cff has 1.2.2"),
        ("CHANGELOG.md", "## 1.2.3 - 2026-12-01\n", "", "CHANGELOG.md has 1.2.2"),
        ("CHANGELOG.md", "2026-12-01", "not released", "CHANGELOG.md has no date for 1.2.3"),
        (versions.MANIFEST, "1.2.3", "1.3.0", "the tag is v1.2.3, and addon/blender_manifest.toml needs the tag v1.3.0"),
    ],
)
def test_another_version_stops_a_release(sources, file, old, new, problem):
    text = (sources / file).read_text(encoding="utf-8")
    assert old in text
    (sources / file).write_text(text.replace(old, new, 1), encoding="utf-8")
    assert any(problem in line for line in versions.release_problems("v1.2.3", sources))


def test_a_wheel_that_needs_too_much_is_refused(tmp_path):
    wheel = tmp_path / "sinew-1.0.0-cp311-abi3-manylinux_2_35_x86_64.whl"
    with zipfile.ZipFile(wheel, "w") as archive:
        archive.writestr("_sinew/_sinew.abi3.so", b"\x7fELF GLIBC_2.35\0")
    with pytest.raises(Failure, match=r"glibc 2\.35"):
        release.check_wheel(wheel)
    with zipfile.ZipFile(wheel, "w") as archive:
        archive.writestr("_sinew/__init__.py", "")
    with pytest.raises(Failure, match="holds 0"):
        release.check_wheel(wheel)


def test_zips_of_a_release_and_their_channel(tmp_path, monkeypatch):
    """The zip of this machine's own wheel, checked in full but for its glibc, which is that of the machine."""
    if not all((ROOT / ".build" / f"blender-{version}" / "sinew.stamp").is_file() for version in environment.BLENDERS):
        pytest.skip("NOT TESTED: a Blender is missing under .build")
    monkeypatch.setattr(release, "check_wheel", lambda _wheel: "")
    made = release.make(build_wheel.build(), tmp_path)
    assert made.stat().st_size <= release.MOST_BYTES
    with zipfile.ZipFile(made) as archive:
        manifest = tomllib.loads(archive.read("blender_manifest.toml").decode())
        assert {"LICENSE", "LICENSES-third-party.txt"} <= set(archive.namelist())
    assert len(manifest["platforms"]) == 1
    channel = tmp_path / "channel"
    for _ in range(2):  # the second time, the zip replaces the first
        release.publish([made], channel)
    assert sorted(path.name for path in channel.iterdir()) == ["index.json", made.name]
    assert f'"version": "{manifest["version"]}"' in (channel / "index.json").read_text(encoding="utf-8")


@pytest.mark.slow  # zig is 100 MB to fetch, and the core is compiled again
@pytest.mark.skipif(sys.platform != "linux", reason="glibc is a library of Linux")
def test_the_portable_wheel_needs_an_old_glibc_only(tmp_path):
    wheel = build_wheel.build_portable()
    assert "manylinux_2_28" in wheel.name
    assert release.check_wheel(wheel).startswith("needs glibc 2.")
    assert release.make(wheel, tmp_path).is_file()


def test_a_zip_that_is_too_large_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(release, "check_wheel", lambda _wheel: "")
    monkeypatch.setattr(release, "MOST_BYTES", 1000)
    with pytest.raises(Failure, match="the largest allowed is 1,000"):
        release.make(build_wheel.build(), tmp_path)


def test_the_licences_of_all_crates_are_in_the_file():
    if shutil.which("cargo") is None:
        pytest.skip("NOT TESTED: cargo is not installed")
    assert third_party.TARGET.read_text(encoding="utf-8") == third_party.text(), "run python3 scripts/third_party.py"
