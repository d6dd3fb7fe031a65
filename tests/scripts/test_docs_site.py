"""The site: a strict build finds what is wrong with pages, formulas and citations, and shows what is right."""

import html
import re
from pathlib import Path

import pytest
from build.console import Failure
from docs_site import external_links, stub_page

import docs

STUB = '''"""About."""
class Belly:
    """A belly (mathematics/muscles.md, Muscle).

    name: unique.
    """
    def pose(self, at: float) -> int:
        """Poses it."""
'''


def build_site(folder, **pages):
    """Builds a site of these pages with the real configuration; returns the folder of the site."""
    source = folder / "docs"
    source.mkdir()
    for name, text in pages.items():
        (source / f"{name}.md").write_text(text, encoding="utf-8")
    config = docs.CONFIG.read_text(encoding="utf-8").replace("../../docs", str(source))
    config = config.replace("hooks.py", str(docs.CONFIG.with_name("hooks.py")))
    nav = "\n".join(f"  - {name}.md" for name in [*pages, "core", "contributing", "changes"] if name != "orphan")
    (folder / "mkdocs.yml").write_text(f"{config[: config.index('nav:')]}nav:\n{nav}\n", encoding="utf-8")
    docs.build(folder / "mkdocs.yml", folder / "site")
    return folder / "site"


def test_a_strict_build_names_every_fault(tmp_path):
    with pytest.raises(Failure) as failure:
        build_site(
            tmp_path,
            index="# A\n\n[a](nothing.md) [b](other.md#nothing)\n\n$\\nocommand x$\n\n```math\n\\frac{\n```\n",
            other="# B\n",
            orphan="# C\n",
        )
    message = str(failure.value)
    for fault in ("'nothing.md'", "'other.md#nothing'", r"unknown command \nocommand", r"'\\frac{' cannot", "orphan.md"):
        assert fault in message, fault
    assert "mathematics/muscles.md, which does not exist" in message  # the stub cites pages that this site lacks


def test_the_real_site_builds_and_needs_no_network(tmp_path):
    """The strict build of all pages, which takes 3 s: it is the test of the links between them."""
    docs.build(site=tmp_path)
    page = (tmp_path / "mathematics/muscles.html").read_text(encoding="utf-8")
    assert page.count("<math") > 40 and "arithmatex" not in page
    loaded = re.compile(
        r'<(?:script|img|iframe)[^>]*src="https?:|<link[^>]*rel="(?:stylesheet|preconnect)"[^>]*href="https?:'
    )
    assert [path.name for path in tmp_path.rglob("*.html") if loaded.search(path.read_text(encoding="utf-8"))] == []
    index = (tmp_path / "llms.txt").read_text(encoding="utf-8")
    named = re.findall(r"\]\(([\w/]+\.html)\)", index)
    assert len(named) > 40 and [name for name in named if not (tmp_path / name).is_file()] == []
    core = html.unescape((tmp_path / "core.html").read_text(encoding="utf-8"))
    for word in ('id="skeleton"', 'id="musculaturepose"', "Raises ValueError", "mathematics/muscles.html#tissues"):
        assert word in core


def test_the_page_of_a_stub():
    text, problems = stub_page.page_of(STUB, {"mathematics/muscles.md": ["Muscle"]})
    assert problems == []
    assert "## Belly" in text and "[muscles.md, Muscle](mathematics/muscles.md#muscle)" in text
    assert "### Belly.pose" in text and "Belly.pose(at: float) -> int" in text and "`name`: unique." in text
    assert stub_page.page_of(STUB, {"mathematics/muscles.md": []})[1] == [
        "cites mathematics/muscles.md, Muscle, and the page has no such heading"
    ]


def test_addresses_outside_are_found_and_checked(tmp_path, monkeypatch):
    import http.server
    import threading

    class Answers(http.server.BaseHTTPRequestHandler):
        def do_GET(self):
            self.send_response({"/good": 200, "/refused": 403}.get(self.path, 404))
            self.end_headers()

        def log_message(self, *_):
            pass

    server = http.server.HTTPServer(("127.0.0.1", 0), Answers)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    at = f"http://127.0.0.1:{server.server_port}"
    try:
        assert external_links.problem_of(f"{at}/good") == external_links.problem_of(f"{at}/refused") == ""
        assert external_links.problem_of(f"{at}/gone") == "404"
    finally:
        server.shutdown()
        server.server_close()
    assert external_links.problem_of(f"{at}/good")  # nobody answers
    page = tmp_path / "page.md"
    page.write_text("[a](https://a.example/b), (https://c.example). http://localhost:8000\n", encoding="utf-8")
    monkeypatch.setattr(external_links.pages, "all_pages", lambda: [page])
    monkeypatch.setattr(external_links.pages, "name_of", lambda found: Path(found).name)
    assert external_links.addresses() == {"https://a.example/b": ["page.md"], "https://c.example": ["page.md"]}
