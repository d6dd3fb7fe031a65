"""The exported body in a browser: what three.js shows is what Blender showed."""

import re
import shutil
import subprocess
import sys

import pytest
from build.layout import ROOT, SCRIPTS

MISSING = [program for program in ("node", "npm") if shutil.which(program) is None]


@pytest.mark.slow
@pytest.mark.skipif(bool(MISSING), reason=f"the page needs {' and '.join(MISSING)}, not found here")
def test_the_page_shows_what_blender_showed(tmp_path):
    command = [sys.executable, SCRIPTS / "export_page.py", "--keys", "frames", "--output", tmp_path]
    done = subprocess.run(list(map(str, command)), cwd=ROOT, text=True, capture_output=True)
    assert done.returncode == 0, done.stderr
    found = dict(re.findall(r"page from (.*), 48 frames: .* ([\d.]+) at most", done.stdout))
    assert float(found["Blender's export copy"]) < 0.02  # mm
    assert float(found["Blender's live skin"]) < 2.0
    assert "not found again: 0" in done.stdout
    assert "the browser says" not in done.stderr
    assert (tmp_path / "player.png").stat().st_size > 50_000
