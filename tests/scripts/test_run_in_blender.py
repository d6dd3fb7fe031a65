"""scripts/run_in_blender.py, the stable interface for scripts outside this repository."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

PROBE = """
import json, os, sys
import bpy, _sinew

path = list(sys.path)

def is_there():
    return hasattr(bpy.types, "SINEW_OT_bind") and hasattr(bpy.types.Object, "sinew")

saved = os.path.join(os.path.dirname(__file__), f"{os.getpid()}.blend")
resets = {"at first": is_there()}
for name, reset in {
    "factory settings": lambda: bpy.ops.wm.read_factory_settings(),
    "empty factory settings": lambda: bpy.ops.wm.read_factory_settings(use_empty=True),
    "home file": lambda: bpy.ops.wm.read_homefile(),
    "empty factory home file": lambda: bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True),
    "saved": lambda: bpy.ops.wm.save_as_mainfile(filepath=saved),
    "opened": lambda: bpy.ops.wm.open_mainfile(filepath=saved),
    "factory settings again": lambda: bpy.ops.wm.read_factory_settings(use_empty=True),
}.items():
    reset()
    resets[name] = is_there()
with open(sys.argv[1], "w") as file:
    json.dump({
        "version": bpy.app.version[:2], "argv": sys.argv, "path": path, "folder": os.getcwd(), "name": __name__,
        "core": _sinew.__file__, "environment": sys.prefix, "resets": resets,
    }, file)
sys.exit(7)
"""


@pytest.fixture
def script(tmp_path):
    """Writes a script and returns the command that runs it in a Blender."""

    def write(text):
        path = tmp_path / "its folder" / "script.py"
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)
        return lambda version, *args: [
            sys.executable, str(ROOT / "scripts/run_in_blender.py"), "--blender", version, str(path), *args
        ]  # fmt: skip

    return write


def run(command, **options):
    return subprocess.run(command, capture_output=True, text=True, timeout=600, **options)


def test_a_script_runs_as_if_python_had_started_it_and_the_extension_survives_resets(version, script, tmp_path):
    done = run(script(PROBE)(version, str(tmp_path / "found.json"), "--flag", "two words"), cwd=tmp_path)
    assert done.returncode == 7, done.stderr
    found = json.loads((tmp_path / "found.json").read_text())
    assert found["version"] == [int(part) for part in version.split(".")]
    assert found["argv"][1:] == [str(tmp_path / "found.json"), "--flag", "two words"]
    assert found["path"][0] == str(tmp_path / "its folder")
    assert str(ROOT / "scripts") not in found["path"]
    assert found["folder"] == str(tmp_path)
    assert found["name"] == "__main__"
    assert f"extensions{os.sep}.local" in found["core"], "the imported wheel is not the one in the zip"
    assert not found["core"].startswith(found["environment"])
    assert all(found["resets"].values()), found["resets"]


@pytest.mark.parametrize(
    ("text", "code", "on_stderr"),
    [
        ("print('text')", 0, ""),
        ("raise SystemExit", 0, ""),
        ("import sys; sys.exit('the reason')", 1, "the reason"),
        ("def wrong():\n    raise ValueError('seen')\n\nwrong()", 1, 'script.py", line 2, in wrong'),
        ("1 +", 1, "SyntaxError"),
        ("import os; os.abort()", 134, ""),
    ],
)
def test_exit_codes_and_tracebacks_are_passed_on(a_version, script, text, code, on_stderr):
    done = run(script(text)(a_version))
    assert done.returncode == code, done.stderr
    assert on_stderr in done.stderr


def test_standard_output_holds_only_the_scripts_output(version, script):
    assert run(script("print('only this')")(version)).stdout == "only this\n"


def test_several_processes_run_at_the_same_time(version, script, tmp_path):
    command = script(PROBE)
    started = [subprocess.Popen(command(version, str(tmp_path / f"{i}.json")), cwd=tmp_path) for i in range(3)]
    assert [process.wait(timeout=600) for process in started] == [7, 7, 7]
    for i in range(3):
        assert all(json.loads((tmp_path / f"{i}.json").read_text())["resets"].values())


def test_a_missing_script_is_an_error(tmp_path):
    done = run([sys.executable, str(ROOT / "scripts/run_in_blender.py"), str(tmp_path / "none.py")])
    assert done.returncode == 2
    assert "none.py" in done.stderr
