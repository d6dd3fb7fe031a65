"""Runs pytest in this process's bpy, for scripts/test.py.

usage: python3 scripts/run_in_blender.py scripts/testing/pytest_in_blender.py [PYTEST OPTION...]
"""

import sys

import pytest

if __name__ == "__main__":
    sys.exit(pytest.main(sys.argv[1:]))
