"""Comments, docstrings and strings are free of the words that docs/GLOSSARY.md replaces in all contexts."""

import re

import pytest
from build.layout import ROOT
from testing import prose

FOLDERS = ("addon", "scripts", "rust", "tests", "farm")
SUFFIXES = {".py", ".pyi", ".rs", ".js", ".mjs"}
SKIPPED_FOLDERS = {"node_modules", "target", "__pycache__"}
BANNED = (
    "told",
    "stands",
    "anew",
    "amiss",
    "bereft",
    "shall",
    "goes round",
    "comes to lie",
    "come to lie",
    "mend",
    "mended",
)
LITERAL = r"(?!stands\s+on\b)"  # a body stands on four legs
PATTERN = re.compile(
    r"(?<![\w`])" + LITERAL + "(?:" + "|".join(word.replace(" ", r"\s+") for word in BANNED) + r")(?![\w`])", re.IGNORECASE
)


def banned_in(path):
    """`line: phrase` for each banned phrase in the prose of a file."""
    return [
        f"{line + text.count(chr(10), 0, match.start())}: {match[0]!r}"
        for line, text in prose.of_file(path)
        for match in PATTERN.finditer(text)
    ]


def sources():
    for folder in FOLDERS:
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix in SUFFIXES and not SKIPPED_FOLDERS.intersection(path.parts) and path.name != "test_words.py":
                yield path


@pytest.mark.parametrize("folder", FOLDERS)
def test_prose_has_no_banned_words(folder):
    paths = [path for path in sources() if path.is_relative_to(ROOT / folder)]
    assert paths
    assert [f"{path.relative_to(ROOT)}:{hit}" for path in paths for hit in banned_in(path)] == []


def test_the_glossary_bans_these_words():
    text = (ROOT / "docs/GLOSSARY.md").read_text(encoding="utf-8")
    table = text[text.index("## Words to avoid") :]
    stems = {word.removesuffix("ed").replace("come to", "comes to") for word in BANNED}
    assert sorted(stem for stem in stems if stem not in table) == []


@pytest.mark.parametrize(
    ("name", "source", "hits"),
    [
        ("a.py", "# it is told\nx = 1\n", ["1: 'told'"]),
        ("a.py", '"""First.\n\nWhat shall be."""\n', ["3: 'shall'"]),
        ("a.py", "told = 1\nx = f'{told} stands'\n", ["2: 'stands'"]),
        ("a.py", "# the body stands on four legs, and this stands for that\n", ["1: 'stands'"]),
        ("a.py", "# a muscle goes\n# round a bone\n", ["1: 'goes\\n round'"]),
        ("a.py", "x = 'withstands, commended, recommend, shallow, untold, `shall`, told_x'\n", []),
        ("a.rs", "/// A point comes\n/// to lie here.\nfn told() {}\n", ["1: 'comes\\n to lie'"]),
        ("a.rs", "const Q: char = '\"'; // Mend it\n", ["1: 'Mend'"]),
        ("a.rs", 'let x = r#"say "anew""#; let told = "a\\"b";\n', ["1: 'anew'"]),
        ("a.rs", "fn f<'a>(told: &'a str) -> &'a str { told }\n", []),
        ("a.js", "/* amiss */ const told = 1;\n", ["1: 'amiss'"]),
    ],
)
def test_only_prose_is_searched(tmp_path, name, source, hits):
    path = tmp_path / name
    path.write_text(source, encoding="utf-8")
    assert banned_in(path) == hits
