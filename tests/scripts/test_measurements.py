"""Measurements: every one has its page and its command, and a page names the commit and the command of its output."""

import re
import sys

import measurements
import pytest
from build.console import Failure
from build.layout import ROOT


def test_a_measured_page_has_its_command_its_commit_and_numbers():
    written = {path.stem: path.read_text(encoding="utf-8") for path in measurements.PAGES.glob("*.md")}
    assert {"quality", "bake", "growth", "reach", "export"} <= set(written) <= set(measurements.MEASUREMENTS)
    for name, text in written.items():
        commit = re.search(r"^Measured at commit `([0-9a-f]{8})`\.$", text, re.MULTILINE)
        assert commit, name
        output = text[text.index("```text\n") + len("```text\n") : text.rindex("\n```")]
        head, _, _ = text.partition("\n\n`python3")
        assert head == f"# {measurements.MEASUREMENTS[name][0]}"
        command = f"`python3 {' '.join(measurements.MEASUREMENTS[name][1])}`"
        assert command in text and re.search(r"\d", output), name


def test_a_page_is_what_the_command_printed(monkeypatch, tmp_path):
    script = tmp_path / "script.py"
    script.write_text("import sys; print('12 mm', sys.argv[1] != 'DIR')", encoding="utf-8")
    monkeypatch.setitem(measurements.MEASUREMENTS, "one", ("One", [str(script), "DIR"]))
    text = measurements.page("one", measurements.measure("one"), "0123abcd")
    assert "```text\n12 mm True\n```" in text and "`0123abcd`" in text


@pytest.mark.parametrize("source", ["raise SystemExit(3)", "pass"])
def test_a_command_that_fails_or_prints_nothing_writes_no_page(monkeypatch, tmp_path, source):
    script = tmp_path / "script.py"
    script.write_text(source, encoding="utf-8")
    monkeypatch.setitem(measurements.MEASUREMENTS, "one", ("One", [str(script)]))
    with pytest.raises(Failure, match="failed with 3|printed nothing"):
        measurements.measure("one")


def test_sources_that_are_not_committed_are_refused(monkeypatch):
    monkeypatch.setattr(measurements, "_git", lambda *arguments: " M addon/x.py" if "status" in arguments else "0123abcd")
    with pytest.raises(Failure, match="addon/x.py"):
        measurements.commit_of_sources()


def test_an_unknown_measurement_is_an_error(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["measurements.py", "none"])
    with pytest.raises(SystemExit):
        measurements.main()
    assert "no measurement none" in capsys.readouterr().err
    assert not (ROOT / "docs/measured/none.md").exists()
