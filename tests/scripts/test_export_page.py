"""The exported body in a browser: three.js shows the same points as Blender."""

import re
import shutil
import subprocess
import sys

import pytest
from build.layout import ROOT, SCRIPTS

MISSING = [program for program in ("node", "npm") if shutil.which(program) is None]


@pytest.mark.slow
@pytest.mark.skipif(bool(MISSING), reason=f"the page needs {' and '.join(MISSING)}, which is not installed")
def test_the_page_shows_the_same_points_as_blender(tmp_path):
    command = [sys.executable, SCRIPTS / "export_page.py", "--keys", "frames", "--output", tmp_path]
    done = subprocess.run(list(map(str, command)), cwd=ROOT, text=True, capture_output=True)
    assert done.returncode == 0, done.stderr
    largest = dict(re.findall(r"page from (.*), 48 frames: .* ([\d.]+) at most", done.stdout))
    assert float(largest["Blender's export copy"]) < 0.02  # mm
    assert float(largest["Blender's live skin"]) < 2.0
    assert ", 0 not found again" in done.stdout
    assert "message of the browser" not in done.stderr
    assert (tmp_path / "player.png").stat().st_size > 50_000
