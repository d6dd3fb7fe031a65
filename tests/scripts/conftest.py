"""Fixtures for tests of the scripts: the Blenders that scripts/build/environment.py has made. A missing one is skipped."""

import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
VERSIONS = ("5.2", "4.5")


def is_made(version):
    return (ROOT / ".build" / f"blender-{version}" / "sinew.stamp").is_file()


@pytest.fixture(params=VERSIONS)
def version(request):
    """Each Blender in turn."""
    if not is_made(request.param):
        pytest.skip(f"NOT TESTED: there is no Blender {request.param} under .build")
    return request.param


@pytest.fixture(scope="session")
def a_version():
    """Any Blender, for tests that do not depend on the version."""
    return next(version for version in VERSIONS if is_made(version))
