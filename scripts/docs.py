"""Builds the documentation's site into .build/site, and fails on a dead link, a page without a place, or a broken formula.

usage: python3 scripts/docs.py [--serve | --external]

The pages are the Markdown files in docs, which also read well without the site. MkDocs with the theme Material takes them as
they are, with GitHub's formulas and tables; Sphinx with MyST would need other Markdown for formulas, and its autodoc would
import Blender. The environment is .build/docs, with the versions in scripts/locks/docs.txt. --serve shows the site on
http://localhost:8000 and builds it again when a page changes. --external also checks every address outside the site, which
needs the network.
"""

import argparse
import os
import subprocess
import sys
from pathlib import Path

from build import environment
from build.console import Failure, run, say, step
from build.layout import BUILD, ROOT, SCRIPTS
from docs_site import external_links

CONFIG = SCRIPTS / "docs_site/mkdocs.yml"
SITE = BUILD / "site"


def build(config: Path = CONFIG, site: Path = SITE) -> None:
    """Builds the site. Raises Failure with MkDocs's messages."""
    mkdocs = environment.program(environment.docs(), "mkdocs")
    with step("building the documentation's site"):
        # without --quiet: it would hide warnings, and hidden warnings do not count in a strict build
        command: list[str | Path] = [mkdocs, "build", "--strict", "--config-file", config, "--site-dir", site]
        run(command, cwd=ROOT, env=os.environ | {"NO_MKDOCS_2_WARNING": "1"})


def main() -> int:
    parser = argparse.ArgumentParser(description="Builds the documentation's site.")
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--serve", action="store_true", help="show the site on this machine")
    what.add_argument("--external", action="store_true", help="check the addresses outside the site, too")
    wanted = parser.parse_args()
    try:
        if wanted.serve:
            mkdocs = environment.program(environment.docs(), "mkdocs")
            return subprocess.run([mkdocs, "serve", "--config-file", CONFIG], cwd=ROOT).returncode
        build()
        if wanted.external:
            dead = external_links.dead()
            if dead:
                raise Failure("\n".join(dead))
    except Failure as error:
        print(f"sinew: {error}", file=sys.stderr)
        return 1
    say(f"the site is {SITE / 'index.html'}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
