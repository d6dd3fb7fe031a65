"""The pages: links lead to pages and headings that exist, and the commands in them are understood by the real programs."""

import argparse
import contextlib
import io
import re
import runpy
import shlex
import subprocess
import sys

import pytest
from build.layout import ROOT
from docs_site import pages

TESTED_ELSEWHERE = {
    "python": "tests/blender/test_examples.py runs it",
    "math": "scripts/docs.py converts it",
    "text": "it is a drawing, not code",
}
INLINE = re.compile(r"`((?:python3 )?scripts/[\w/]+\.py [^`]*|python3 [\w/]+\.py[^`]*)`")


def commands():
    """(where, command) of every command in the pages: the lines of `sh` blocks, and code in sentences."""
    for page in pages.all_pages():
        for block in pages.blocks_of(page):
            if block.language == "sh":
                lines = block.code.replace("\\\n", " ").splitlines()
                yield from ((str(block), line) for line in lines if line.strip())
        prose = pages.FENCE.sub("", page.read_text(encoding="utf-8"))
        yield from ((pages.name_of(page), " ".join(found.split())) for found in INLINE.findall(prose))


def problem_of(command):
    """Why a command of the pages cannot work, or an empty text."""
    words = shlex.split(command)
    if words[:1] == ["python3"]:
        words = words[1:]
    if words[0].endswith(".py"):
        return problem_of_script(words)
    if words[:3] == ["pip", "install", "-r"]:
        return "" if (ROOT / words[3]).is_file() else f"there is no file {words[3]}"
    if words[0] == "blender":
        return ""  # tests/blender/test_examples.py parses it
    return "no test knows how to check this command"


def problem_of_script(words):
    script, arguments = words[0], [{"N": "3", "K": "1"}.get(word, word) for word in words[1:]]
    if not (ROOT / script).is_file():
        return f"there is no script {script}"
    if script == "scripts/run_in_blender.py" and arguments:
        inner = next((at for at, word in enumerate(arguments) if word.endswith(".py")), len(arguments))
        problem = problem_of_inner_script(arguments[inner:])
        if problem:
            return problem
    if not arguments:
        return ""
    if "argparse" not in (ROOT / script).read_text(encoding="utf-8"):
        return f"{script} takes no arguments"
    if script.startswith(("scripts/exports/", "scripts/benchmarks/", "farm/")):
        return problem_of_inner_script([script, *arguments])  # it imports Blender or Dask before it parses
    return problem_of_arguments(script, arguments)


class Parsed(BaseException):
    """Ends a script once it has parsed its arguments."""


def problem_of_arguments(script, arguments):
    """Runs a script up to the point where it has parsed its arguments; returns its error, or an empty text."""
    parse = argparse.ArgumentParser.parse_args

    def parse_and_stop(self, *given, **named):
        parse(self, *given, **named)
        raise Parsed

    errors = io.StringIO()
    with pytest.MonkeyPatch.context() as patch, contextlib.redirect_stderr(errors):
        patch.setattr(argparse.ArgumentParser, "parse_args", parse_and_stop)
        patch.setattr(sys, "argv", [script, *arguments])
        try:
            runpy.run_path(str(ROOT / script), run_name="__main__")
        except Parsed:
            return ""
        except SystemExit:
            return errors.getvalue()
    return f"{script} did not parse its arguments"


def problem_of_inner_script(words):
    """A script that imports Blender: it exists, and its source names the options."""
    if not words or not (ROOT / words[0]).is_file():
        return f"there is no script {words[0] if words else ''}"
    source = (ROOT / words[0]).read_text(encoding="utf-8")
    options = [word.partition("=")[0] for word in words[1:] if word.startswith("--")]
    unknown = [option for option in options if f'"{option}"' not in source]
    return f"{words[0]} has no option {unknown[0]}" if unknown else ""


def test_links_lead_to_pages_and_headings_that_exist():
    targets = [(page, target) for page in pages.all_pages() for target in pages.links_of(page)]
    inside = [(page, target) for page, target in targets if "://" not in target and not made_by_the_site(page, target)]
    assert len(inside) > 100
    assert [problem for page, target in inside if (problem := pages.problem_of(page, target))] == []


def made_by_the_site(page, target):
    """Pages of the site that scripts/docs_site/hooks.py makes. A strict build checks links to them."""
    return page.parent.name == "docs" and target in ("core.md", "contributing.md", "changes.md")


@pytest.mark.parametrize(
    ("target", "problem"),
    [
        ("docs/quality.md#iterations", ""),
        ("docs/quality.md#nothing", "README.md: docs/quality.md has no heading #nothing"),
        ("docs/nothing.md", "README.md: docs/nothing.md does not exist"),
        ("#install", ""),
    ],
)
def test_a_dead_link_is_found(target, problem):
    assert pages.problem_of(ROOT / "README.md", target) == problem


def test_links_in_code_are_not_links(tmp_path):
    page = tmp_path / "page.md"
    page.write_text("[a](b.md) `[c](d.md)`\n\n```sh\n[e](f.md)\n```\n\n![g [h]](i.png)\n", encoding="utf-8")
    assert pages.links_of(page) == ["b.md", "i.png"]


def test_commands_are_understood():
    found = sorted({command: where for where, command in commands()}.items())
    assert len(found) > 20
    assert [f"{where}: {command}: {problem}" for command, where in found if (problem := problem_of(command))] == []


@pytest.mark.parametrize(
    "command",
    [
        "python3 scripts/demo.py --no-such-option",
        "python3 scripts/no_such_script.py",
        "python3 scripts/run_in_blender.py scripts/no_such_script.py",
        "python3 scripts/run_in_blender.py scripts/benchmarks/bake_table.py --no-such-option",
        "pip install -r no_such_file.txt",
        "make",
    ],
)
def test_a_wrong_command_is_found(command):
    assert problem_of(command)


def test_every_block_of_code_is_tested():
    blocks = [block for page in pages.all_pages() for block in pages.blocks_of(page)]
    assert [str(block) for block in blocks if block.language not in {"sh", *TESTED_ELSEWHERE}] == []


def test_the_first_page_is_short_and_names_the_commands():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(text.splitlines()) <= 100
    for command in ("python3 scripts/demo.py", "python3 scripts/test.py", ".ci/run"):
        assert command in text
    assert "docs/demo.png" in text.split("## ", 1)[0]


def test_measurements_name_the_commit_that_recorded_them():
    marked = [
        (pages.name_of(page), line)
        for page in pages.all_pages()
        for line in page.read_text(encoding="utf-8").splitlines()
        if line.startswith("Measured at")
    ]
    assert len(marked) > 10
    assert [found for found in marked if not re.match(r"Measured at commit `[0-9a-f]{8}`[.;,]", found[1])] == []


def test_the_commits_that_pages_name_exist():
    """Measurements name commits of this repository. A rebase or squash would leave names of nothing."""
    git = ["git", "-C", str(ROOT)]
    shallow = subprocess.run([*git, "rev-parse", "--is-shallow-repository"], capture_output=True, text=True)
    if shallow.stdout.strip() != "false":
        pytest.skip("NOT TESTED: this copy has no history")
    text = "".join(page.read_text(encoding="utf-8") for page in pages.all_pages())
    named = sorted(set(re.findall(r"commit `([0-9a-f]{8})`", text)))
    assert len(named) > 5

    reached = subprocess.run([*git, "log", "--format=%h", "--abbrev=8"], capture_output=True, text=True).stdout.split()
    assert [commit for commit in named if commit not in reached] == []
