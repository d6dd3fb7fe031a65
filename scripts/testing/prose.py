"""Reads the prose in source files: comments, docstrings and strings, with their lines.

tests/scripts/test_words.py looks in it for words that docs/GLOSSARY.md bans. Names in the code are not prose.
"""

import ast
import io
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path

# In Rust and JavaScript. A character literal is matched so that a quote in it does not start a string.
_C_LIKE = re.compile(
    r"""(?P<prose>//[^\n]*|/\*.*?\*/|\br(?P<hashes>\#*)".*?"(?P=hashes)|"(?:\\.|[^"\\])*")|'(?:\\[^\n]|[^'\\\n])'""",
    re.DOTALL | re.VERBOSE,
)
_COMMENT_START = re.compile(r"^[ \t]*(?:#|//[/!]?)", re.MULTILINE)


def of_file(path: Path) -> list[tuple[int, str]]:
    """The prose of a Python, Rust or JavaScript file: the first line and the text of each piece.

    Comments on successive lines are one piece, so that a phrase may continue on the next line.
    """
    source = path.read_text(encoding="utf-8")
    pieces = _of_python(source) if path.suffix in (".py", ".pyi") else _of_c_like(source)
    return _joined(sorted(pieces))


def _of_python(source: str) -> Iterator[tuple[int, str]]:
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            yield token.start[0], token.string
    for node in ast.walk(ast.parse(source)):  # includes the constant parts of f-strings
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.lineno, node.value


def _of_c_like(source: str) -> Iterator[tuple[int, str]]:
    for match in _C_LIKE.finditer(source):
        if match["prose"]:
            yield source.count("\n", 0, match.start()) + 1, match["prose"]


def _joined(pieces: list[tuple[int, str]]) -> list[tuple[int, str]]:
    joined: list[tuple[int, str]] = []
    last_line = 0
    for line, text in pieces:
        is_comment = _COMMENT_START.match(text) is not None
        if joined and is_comment and line == last_line + 1:
            joined[-1] = joined[-1][0], f"{joined[-1][1]}\n{text}"
        else:
            joined.append((line, text))
        last_line = line if is_comment else 0
    return [(line, _COMMENT_START.sub("", text)) for line, text in joined]
