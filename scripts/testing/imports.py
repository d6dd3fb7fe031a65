"""Reads the imports between the rooms of the add-on and of the Rust core from the text of the sources.

A room is a folder of `addon/` or of `rust/core/src/`. Rooms have an order: a file imports only from its own room and from
rooms before it. docs/ARCHITECTURE.md shows the order; `architecture_picture.py` draws it, and
tests/scripts/test_architecture.py keeps it.
"""

import ast
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from build.layout import ROOT

ADDON, CORE = ROOT / "addon", ROOT / "rust/core/src"
ADDON_ROOMS = (
    "errors", "files", "languages", "scene", "display", "settings", "muscles", "live", "skin", "measure", "reach", "bake",
    "export", "command_line", "operators", "ui",
)  # fmt: skip
CORE_ROOMS = (
    "error",
    "math",
    "faults",
    "parallel",
    "ellipsoid",
    "pose",
    "muscles",
    "fit",
    "skin",
    "surface",
    "reach",
    "bake",
    "measure",
)
_USE = re.compile(r"^\s*(?:pub(?:\([^)]*\))? )?use ((?:crate|super|self)::[^;]+);", re.MULTILINE)
_PATH = re.compile(r"\bcrate(?:::\w+)+")


@dataclass(frozen=True)
class Import:
    """One import: its file, and the importing and the imported module as dotted names below the sources' folder."""

    file: Path
    importer: str
    imported: str


def of_addon() -> list[Import]:
    """All imports within the add-on, including those inside functions."""
    modules = {_module(file, ADDON): file for file in sorted(ADDON.rglob("*.py"))}
    return [
        Import(file, name, target)
        for name, file in modules.items()
        for target in _python_targets(ast.parse(file.read_text(encoding="utf-8")), name, file, modules)
    ]


def of_core() -> list[Import]:
    """All uses of another module of the core, by `use` or by a `crate::` path, without re-exports of the crate's root."""
    modules = {_module(file, CORE): file for file in sorted(CORE.rglob("*.rs")) if file.name != "lib.rs"}
    found = set()
    for name, file in modules.items():
        text = re.sub(r"//.*", "", file.read_text(encoding="utf-8"))
        paths = [path for use in _USE.findall(text) for path in _without_braces(use)] + _PATH.findall(text)
        for path in paths:
            imported = _longest_module(_absolute(path, name, file), modules)
            if imported and imported != name and file.name != "mod.rs":  # a mod.rs lists its children
                found.add(Import(file, name, imported))
    return sorted(found, key=lambda one: (one.importer, one.imported))


def room_of(module: str) -> str:
    """The room of a module; empty for a file of the top level."""
    return module.partition(".")[0]


def between_rooms(imports: Iterable[Import]) -> dict[tuple[str, str], int]:
    """The number of imports from each room to each other room, without imports within a room and of the top level."""
    counts: dict[tuple[str, str], int] = {}
    for found in imports:
        ends = room_of(found.importer), room_of(found.imported)
        if ends[0] != ends[1] and all(ends):
            counts[ends] = counts.get(ends, 0) + 1
    return counts


def against_order(imports: Iterable[Import], rooms: tuple[str, ...]) -> list[str]:
    """A line for each import of a later room, and for each import between rooms that are not in the order."""
    rank = {room: number for number, room in enumerate(rooms)}
    lines = []
    for found in imports:
        importer, imported = room_of(found.importer), room_of(found.imported)
        if not importer or not imported or importer == imported:
            continue
        if importer not in rank or imported not in rank:
            lines.append(f"{found.importer} imports {found.imported}: a room is not in the order")
        elif rank[importer] < rank[imported]:
            lines.append(f"{found.importer} imports {found.imported}")
    return lines


def circles(imports: Iterable[Import]) -> list[list[str]]:
    """The groups of modules that import each other in a circle (strongly connected components of two or more)."""
    graph: dict[str, set[str]] = {}
    for found in imports:
        if found.importer != found.imported:
            graph.setdefault(found.importer, set()).add(found.imported)
            graph.setdefault(found.imported, set())
    reach = {module: _reachable(module, graph) for module in graph}
    groups = {
        frozenset(other for other in reach[module] if module in reach[other]) for module in graph if module in reach[module]
    }
    return sorted(sorted(group) for group in groups)


def _reachable(start: str, graph: dict[str, set[str]]) -> set[str]:
    seen: set[str] = set()
    waiting = list(graph[start])
    while waiting:
        module = waiting.pop()
        if module not in seen:
            seen.add(module)
            waiting += graph[module]
    return seen


def _without_braces(use: str) -> list[str]:
    """The paths of a `use`: a::b, a::c::d and a::c::e for `a::{b, c::{d, e}}`."""
    use = re.sub(r"\s+|\bas \w+", "", use)
    start = use.find("{")
    if start < 0:
        return [use]
    parts, depth, part = [], 0, ""
    for letter in use[start + 1 : use.rfind("}")]:
        depth += (letter == "{") - (letter == "}")
        if letter == "," and depth == 0:
            parts.append(part)
            part = ""
        else:
            part += letter
    return [path for part in [*parts, part] if part for path in _without_braces(use[:start] + part)]


def _absolute(path: str, module: str, file: Path) -> list[str]:
    """The path from the crate's root, without `crate`."""
    words = path.split("::")
    base = module.split(".")
    if words[0] == "crate":
        return words[1:]
    if words[0] == "self":
        return base + words[1:]
    while words[0] == "super":
        base, words = base[:-1], words[1:]
    return base + words


def _longest_module(words: list[str], modules: dict[str, Path]) -> str:
    while words and ".".join(words) not in modules:
        words = words[:-1]
    return ".".join(words)


def _module(file: Path, folder: Path) -> str:
    parts = list(file.relative_to(folder).with_suffix("").parts)
    return ".".join(parts[:-1] if parts[-1] in ("__init__", "mod") else parts)


def _python_targets(tree: ast.AST, name: str, file: Path, modules: dict[str, Path]) -> Iterator[str]:
    package = name if file.name == "__init__.py" else name.rpartition(".")[0]
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.level:
            parts = package.split(".") if package else []
            base = ".".join([*parts[: len(parts) - node.level + 1], *(node.module.split(".") if node.module else [])])
            for alias in node.names:
                full = f"{base}.{alias.name}".strip(".")
                yield full if full in modules else base
