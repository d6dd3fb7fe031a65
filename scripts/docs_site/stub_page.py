"""Makes the page of the core's Python module from its stub, rust/py/_sinew.pyi."""

import ast
import re

ABOUT = """# The core's Python module

`rust/py/_sinew.pyi` is the source of this page. The extension brings the module, so `import _sinew` works in Blender.

"""
CITATION = re.compile(r"(?:docs/)?mathematics/(\w+\.md)(?:,\s+([A-Z][\w\s]*?\w)(?=[;:.,)]))?")


def page_of(stub: str, headings: dict[str, list[str]]) -> tuple[str, list[str]]:
    """The page as Markdown, and a line for each citation of a heading that does not exist.

    headings: the headings of each page of the documentation, by its path below docs.
    """
    tree = ast.parse(stub)
    parts, problems = [ABOUT, _linked(ast.get_docstring(tree) or "", headings, problems := [])], problems
    for node in tree.body:
        if isinstance(node, ast.ClassDef):
            parts += _class(node, headings, problems)
    parts.append("## Functions\n")
    for node in tree.body:
        if isinstance(node, ast.FunctionDef):
            parts += _function(node, "", headings, problems)
    return "\n".join(parts) + "\n", problems


def _class(node: ast.ClassDef, headings: dict, problems: list) -> list[str]:
    parts = [f"\n## {node.name}\n", _linked(ast.get_docstring(node) or "", headings, problems)]
    for member in node.body:
        if isinstance(member, ast.FunctionDef) and (not member.name.startswith("__") or member.name == "__new__"):
            parts += _function(member, node.name, headings, problems)
    return parts


def _function(node: ast.FunctionDef, owner: str, headings: dict, problems: list) -> list[str]:
    is_property = any(isinstance(mark, ast.Name) and mark.id == "property" for mark in node.decorator_list)
    name = owner if node.name == "__new__" else f"{owner}.{node.name}" if owner else node.name
    returns = f" -> {ast.unparse(node.returns)}" if node.returns and node.name != "__new__" else ""
    signature = (
        f"{name}: {ast.unparse(node.returns)}" if is_property and node.returns else f"{name}({_arguments(node)}){returns}"
    )
    heading = [] if node.name == "__new__" else [f"\n### {name}\n"]
    return [*heading, f"\n```pyi\n{signature}\n```\n", _linked(ast.get_docstring(node) or "", headings, problems)]


def _arguments(node: ast.FunctionDef) -> str:
    text = ast.unparse(node.args)
    text = re.sub(r"^(self|cls)(, )?", "", text)
    return f"\n    {text}\n" if len(text) > 80 else text


def _linked(docstring: str, headings: dict, problems: list) -> str:
    """A docstring as Markdown: names of arguments on lines of their own, and citations as links."""

    def link(match):
        page, heading = f"mathematics/{match[1]}", " ".join((match[2] or "").split())
        if page not in headings:
            problems.append(f"cites {page}, which does not exist")
            return match[0]
        if not heading:
            return f"[{match[1]}]({page})"
        if heading not in headings[page]:
            problems.append(f"cites {page}, {heading}, and the page has no such heading")
            return match[0]
        anchor = re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")
        return f"[{match[1]}, {heading}]({page}#{anchor})"

    text = re.sub(r"(?m)^(\w+(?:, \w+)*): ", r"\n`\1`: ", docstring)
    text = re.sub(r"(?m)^(\w+):\n(?= +- )", r"\n`\1`:\n\n", text)  # a list needs an empty line before it
    text = re.sub(r"(?m)^(Returns|Raises)\b", r"\n\1", text)
    return CITATION.sub(link, text)
