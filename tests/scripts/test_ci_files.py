"""The files of the public CI: they follow their schemas, use what exists, and test what the manifest promises."""

import re
import subprocess

import ci_matrix
import pytest
from build import environment
from build.console import Failure
from build.layout import ON_WINDOWS, ROOT

GITHUB = ROOT / ".github"
WORKFLOWS = sorted((GITHUB / "workflows").glob("*.yml"))
FORMS = sorted((GITHUB / "ISSUE_TEMPLATE").glob("*.yml"))


@pytest.mark.parametrize(
    ("schema", "files"),
    [
        ("github-workflows", WORKFLOWS),
        ("github-issue-forms", [path for path in FORMS if path.name != "config.yml"]),
        ("github-issue-config", [path for path in FORMS if path.name == "config.yml"]),
        ("citation-file-format", [ROOT / "CITATION.cff"]),
    ],
)
def test_files_follow_their_schemas(schema, files):
    assert files
    check = environment.program(environment.docs(), "check-jsonschema")
    done = subprocess.run([check, "--builtin-schema", f"vendor.{schema}", *files], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


def test_workflows_use_scripts_and_files_that_exist():
    for path in WORKFLOWS:
        text = path.read_text(encoding="utf-8")
        used = re.findall(r"(?<![\w./-])((?:scripts|\.github|\.ci)/[\w./-]+)", text)
        assert used, path.name
        assert [name for name in used if not (ROOT / name).exists()] == [], path.name


def test_artifacts_are_uploaded_before_they_are_downloaded():
    text = "".join(path.read_text(encoding="utf-8") for path in WORKFLOWS)
    uploads = set(re.findall(r"upload-artifact@\S+\n\s+with:\s*\{?\s*name: ([\w-]+)", text))
    downloads = set(re.findall(r"download-artifact@\S+\n\s+with: \{(?:name|pattern): ([\w-]+)", text))
    assert downloads and all(any(name.startswith(upload) for upload in uploads) for name in downloads)


def test_every_blender_of_the_manifest_is_in_the_matrix():
    matrices = ci_matrix.matrices()
    assert {entry["blender"] for entry in matrices["blenders"]} == set(environment.BLENDERS)
    platforms = {entry["platform"] for entry in matrices["systems"]}
    assert (
        {entry["platform"] for entry in matrices["blenders"]}
        == platforms
        == {"linux-x64", "windows-x64", "macos-arm64", "macos-x64"}
    )
    assert {entry["python"] for entry in matrices["pythons"]} == {"3.11", "3.12", "3.13", "3.14"}


def test_an_older_blender_in_the_manifest_is_refused(monkeypatch, tmp_path):
    (tmp_path / "addon").mkdir()
    (tmp_path / "addon/blender_manifest.toml").write_text('blender_version_min = "4.2.0"\n', encoding="utf-8")
    monkeypatch.setattr(ci_matrix, "ROOT", tmp_path)
    with pytest.raises(Failure, match=r"4\.2, and the oldest Blender that is tested is 4\.5"):
        ci_matrix.matrices()


def git(folder, *arguments):
    identity = ["-c", "user.name=a", "-c", "user.email=a@localhost", "-c", "init.defaultBranch=main"]
    return subprocess.run(["git", *identity, *arguments], cwd=folder, capture_output=True, text=True, check=True).stdout


@pytest.mark.skipif(ON_WINDOWS, reason="publish.sh runs on Linux only")
def test_a_branch_of_measurements_or_channels_keeps_what_it_has(tmp_path):
    """publish.sh in a clone of an empty repository: a new branch, more files, a replaced folder, and no change."""
    git(tmp_path, "init", "--quiet", "--bare", "origin")
    git(tmp_path, "clone", "--quiet", "origin", "clone")
    clone = tmp_path / "clone"
    (clone / "source.txt").write_text("source")
    git(clone, "add", "source.txt")
    git(clone, "commit", "--quiet", "--message", "first")
    given = tmp_path / "given"

    def publish(path, **files):
        given.mkdir(exist_ok=True)
        for old in given.iterdir():
            old.unlink()
        for name, content in files.items():
            (given / name).write_text(content)
        script = ["bash", str(GITHUB / "publish.sh"), "channels", path, str(given)]
        subprocess.run(script, cwd=clone, check=True, capture_output=True)
        return git(tmp_path / "origin", "ls-tree", "-r", "--name-only", "channels").split()

    assert publish("stable", a="1") == ["stable/a"]
    assert publish("latest", b="2") == ["latest/b", "stable/a"]
    assert publish("latest", c="3") == ["latest/c", "stable/a"]
    commits = git(tmp_path / "origin", "rev-list", "channels").split()
    assert publish("latest", c="3") == ["latest/c", "stable/a"]
    assert git(tmp_path / "origin", "rev-list", "channels").split() == commits and len(commits) == 3
