"""Finds addresses outside the documentation that no longer answer. It needs the network."""

import re
import urllib.error
import urllib.request

from docs_site import pages

ADDRESS = re.compile(r"https?://[^\s<>()\"'`\]]+[^\s<>()\"'`\].,;:]")
TIMEOUT_S = 20.0
OWN_MACHINE = re.compile(r"https?://(localhost|127\.0\.0\.1)\b")


def addresses() -> dict[str, list[str]]:
    """The pages that name each address, without those of the reader's own machine."""
    found: dict[str, list[str]] = {}
    for page in pages.all_pages():
        for address in ADDRESS.findall(page.read_text(encoding="utf-8")):
            if not OWN_MACHINE.match(address):
                found.setdefault(address, []).append(pages.name_of(page))
    return found


def dead() -> list[str]:
    """One line for each address that does not answer, with the pages that name it."""
    return [
        f"{address} ({problem}), in {', '.join(named)}"
        for address, named in addresses().items()
        if (problem := problem_of(address))
    ]


def problem_of(address: str) -> str:
    """Why an address does not answer, or an empty text. A server that refuses programs (403, 429) counts as an answer."""
    request = urllib.request.Request(address, headers={"User-Agent": "Mozilla/5.0 (link check of Sinew's documentation)"})
    try:
        with urllib.request.urlopen(request, timeout=TIMEOUT_S):
            return ""
    except urllib.error.HTTPError as error:
        return "" if error.code in (403, 429) else str(error.code)
    except (OSError, ValueError) as error:
        return str(error)
