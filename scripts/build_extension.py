"""Builds the extension that a user installs: .build/sinew-VERSION-PLATFORM.zip.

usage: python3 scripts/build_extension.py    (prints the zip's path)
"""

import sys

from build import extension
from build.console import Failure


def main() -> None:
    try:
        print(extension.build())
    except Failure as error:
        sys.exit(f"sinew: {error}")


if __name__ == "__main__":
    main()
