"""Hooks of MkDocs: pages that are made from other files, formulas as MathML, and llms.txt.

MkDocs calls the functions by their names. A formula that cannot be converted, and a citation of a heading that does not
exist, are warnings, and a strict build fails on a warning.
"""

import html
import logging
import re
import sys
from pathlib import Path

from latex2mathml import converter
from mkdocs.structure.files import File

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from docs_site import stub_page  # noqa: E402 - MkDocs loads this file by its path

ROOT = Path(__file__).resolve().parents[2]
FORMULA = re.compile(r'<(span|div) class="arithmatex">\\([(\[])(.*?)\\[)\]]</\1>', re.DOTALL)
MATRIX_ROW_END = re.compile(r"\\\\\[[^]]*\]")
UNKNOWN_COMMAND = re.compile(r"\\[A-Za-z]+")
_log = logging.getLogger("mkdocs.hooks.sinew")
_pages = {}


def on_files(files, config):
    """Adds the pages that are made from the stub, CONTRIBUTING.md and CHANGELOG.md."""
    headings = {
        file.src_uri: re.findall(r"^#+ +(.+?) *$", Path(file.abs_src_path).read_text(encoding="utf-8"), re.MULTILINE)
        for file in files.documentation_pages()
    }
    stub = (ROOT / "rust/py/_sinew.pyi").read_text(encoding="utf-8")
    text, problems = stub_page.page_of(stub, headings)
    for problem in problems:
        _log.warning("rust/py/_sinew.pyi: %s", problem)
    made = {"core.md": text}
    for name, target in (("CONTRIBUTING.md", "contributing.md"), ("CHANGELOG.md", "changes.md")):
        source = (ROOT / name).read_text(encoding="utf-8")
        made[target] = source.replace("](docs/", "](").replace("](CHANGELOG.md", "](changes.md")
    for uri, content in made.items():
        files.append(File.generated(config, uri, content=content))
    return files


def on_page_markdown(markdown, page, config, files):
    """Keeps the text of a page for llms.txt."""
    _pages[page.file.src_uri] = (page, markdown)


def on_page_content(content, page, config, files):
    """Replaces the LaTeX of formulas by MathML, which browsers show without a script."""

    def mathml(match):
        is_block, source = match[1] == "div", html.unescape(match[3]).strip()
        try:
            made = converter.convert(MATRIX_ROW_END.sub(r"\\\\", source), display="block" if is_block else "inline")
        except Exception as error:  # the converter raises errors of many kinds
            _log.warning("%s: the formula %r cannot be converted (%r)", page.file.src_uri, source, error)
            return match[0]
        unknown = UNKNOWN_COMMAND.search(made)
        if unknown:  # the converter shows a command that it does not know as text
            _log.warning("%s: the formula %r has the unknown command %s", page.file.src_uri, source, unknown[0])
        return made

    return FORMULA.sub(mathml, content)


def on_post_build(config):
    """Writes llms.txt, an index of the pages for programs that read text, and llms-full.txt, their text."""
    lines = [
        "# Sinew",
        "",
        f"> {config.site_description}: ellipsoids between the bones of an armature, and a live elastic skin.",
        "",
    ]
    full = []
    for uri, (page, markdown) in _pages.items():
        lines.append(f"- [{page.title}]({page.url}): {_first_sentence(markdown)}")
        full.append(f"<!-- {uri} -->\n\n{markdown.strip()}\n")
    site = Path(config.site_dir)
    (site / "llms.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
    (site / "llms-full.txt").write_text("\n".join(full), encoding="utf-8")


def _first_sentence(markdown: str) -> str:
    """The first sentence of prose of a page, without Markdown."""
    prose = next((block for block in markdown.split("\n\n") if block.strip() and block.strip()[0] not in "#|!-`<"), "")
    plain = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", " ".join(prose.split())).replace("*", "").replace("`", "")
    return re.split(r"(?<=\.)\s", plain, maxsplit=1)[0]
