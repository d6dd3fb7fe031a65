"""The rules of the extensions platform that the sources can break; docs/platform_rules.md lists all of them."""

import ast
import sys
import tomllib
import zipfile

import pytest
from build import wheel as build_wheel
from build.layout import ROOT

ADDON = sorted((ROOT / "addon").rglob("*.py"))
MANIFEST = tomllib.loads((ROOT / "addon/blender_manifest.toml").read_text(encoding="utf-8"))
OF_THE_NETWORK = {
    "aiohttp",
    "ftplib",
    "http",
    "httpx",
    "requests",
    "smtplib",
    "socket",
    "ssl",
    "telnetlib",
    "urllib",
    "urllib3",
    "xmlrpc",
}
OF_PROCESSES = {"multiprocessing", "pip", "pty", "subprocess", "venv"}
FROM_BLENDER = {
    "_sinew",
    "addon_utils",
    "blf",
    "bl_ext",
    "bmesh",
    "bpy",
    "bpy_extras",
    "gpu",
    "gpu_extras",
    "mathutils",
    "numpy",
    "rna_prop_ui",
}
FORBIDDEN_CALLS = {"eval", "exec", "compile", "__import__", "system", "popen", "execv", "spawnv"}


def violations_of(source):
    """What a source does that the platform forbids: `line: what`."""
    found = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            names = [node.module]
        else:
            names = []
        for name in names:
            top = name.partition(".")[0]
            if top in OF_THE_NETWORK | OF_PROCESSES or name.startswith(("bl_ext", "sinew", "addon.")):
                found.append(f"{node.lineno}: imports {name}")
        if isinstance(node, ast.Call):
            called = node.func.id if isinstance(node.func, ast.Name) else getattr(node.func, "attr", "")
            is_of_re = isinstance(node.func, ast.Attribute) and getattr(node.func.value, "id", "") == "re"
            if called in FORBIDDEN_CALLS and not is_of_re:
                found.append(f"{node.lineno}: calls {called}")
        if isinstance(node, ast.Attribute) and getattr(node.value, "id", "") == "sys" and node.attr in ("path", "modules"):
            found.append(f"{node.lineno}: uses sys.{node.attr}")
        if isinstance(node, ast.Attribute) and node.attr in ("clipboard", "user_online", "online_access"):
            found.append(f"{node.lineno}: uses {node.attr}")
    return found


def test_the_add_on_keeps_the_rules():
    found = {path.relative_to(ROOT).as_posix(): violations_of(path.read_text(encoding="utf-8")) for path in ADDON}
    assert len(found) > 100
    # the manifest has the permission for these two
    of_clipboard = {path for path, lines in found.items() if any("uses clipboard" in line for line in lines)}
    assert of_clipboard == {"addon/operators/paste_tissue.py", "addon/operators/whats_wrong.py"}
    others = {path: [line for line in lines if "uses clipboard" not in line] for path, lines in found.items()}
    assert {path: lines for path, lines in others.items() if lines} == {}


@pytest.mark.parametrize(
    ("source", "violation"),
    [
        ("exec('x = 1')", "1: calls exec"),
        ("import os\nos.system('ls')", "2: calls system"),
        ("from urllib import request", "1: imports urllib"),
        ("import subprocess", "1: imports subprocess"),
        ("import sys\nsys.path.append('x')", "2: uses sys.path"),
        ("from bl_ext.user_default.sinew import ui", "1: imports bl_ext.user_default.sinew"),
        ("bpy.context.window_manager.clipboard = 'x'", "1: uses clipboard"),
    ],
)
def test_a_violation_is_found(source, violation):
    assert violations_of(source) == [violation]


def test_only_blender_and_python_are_imported():
    tops = set()
    for path in ADDON:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                tops |= {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.level == 0:
                tops.add(node.module.partition(".")[0])
    assert tops - FROM_BLENDER - set(sys.stdlib_module_names) == set()


def test_the_folder_of_the_add_on_is_only_read():
    """`__file__` leads to the presets and to the manifest, and nothing else."""
    users = {path.relative_to(ROOT / "addon").as_posix() for path in ADDON if "__file__" in path.read_text(encoding="utf-8")}
    assert users == {
        "command_line/bake.py",
        "muscles/placing/place/preset_file.py",
        "operators/whats_wrong.py",
        "ui/online_manual.py",
    }


def test_files_are_written_through_one_module_only():
    """Others open files to read them. `merge` writes to the path that `atomic_write` gives.

    Exporters of Blender write where the operator's file name says.
    """
    users = {path.relative_to(ROOT / "addon").as_posix() for path in ADDON if writes_files(path.read_text(encoding="utf-8"))}
    assert users == {"command_line/merge.py", "files/atomic_write.py"}


def writes_files(source):
    for node in ast.walk(ast.parse(source)):
        if not isinstance(node, ast.Call):
            continue
        name = node.func.id if isinstance(node.func, ast.Name) else getattr(node.func, "attr", "")
        owner = getattr(getattr(node.func, "value", None), "id", "")
        mode = next((word.value for word in node.args[1:2] if isinstance(word, ast.Constant)), "r")
        if name == "open" and set(str(mode)) & set("wax+"):
            return True
        if name in ("write_bytes", "write_text") and owner != "report":  # report.write_text fills a text of the blend file
            return True
    return False


@pytest.mark.parametrize(
    ("source", "writes"),
    [("open(path, 'xb')", True), ("open(path)", False), ("open(path, 'rb')", False), ("path.write_text('')", True)],
)
def test_writing_is_found(source, writes):
    assert writes_files(source) is writes


def test_permissions_have_reasons():
    assert set(MANIFEST["permissions"]) == {"files", "clipboard"}
    assert all(0 < len(reason) <= 64 and reason[-1].isalnum() for reason in MANIFEST["permissions"].values())


def test_the_manifest_names_licence_and_holders():
    assert MANIFEST["license"] == ["SPDX:GPL-3.0-or-later"]
    assert any("myo_sim" in holder for holder in MANIFEST["copyright"])
    assert "blender" not in MANIFEST["name"].lower() and len(MANIFEST["tagline"]) <= 64
    assert set(MANIFEST["tags"]) <= {"Animation", "Rigging", "Mesh", "Modeling"}


def test_the_wheel_has_no_python_to_run():
    with zipfile.ZipFile(build_wheel.build()) as archive:
        python = {name: archive.read(name).decode() for name in archive.namelist() if name.endswith(".py")}
    assert list(python) == ["_sinew/__init__.py"]
    assert violations_of(python["_sinew/__init__.py"]) == []


def test_pictures_are_not_heavy():
    sizes = {path.name: path.stat().st_size for path in (ROOT / "docs").rglob("*.png")}
    assert sizes and {name: size for name, size in sizes.items() if size > 1_100_000} == {}
