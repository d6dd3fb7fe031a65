"""Runs pytest inside this process's bpy, for scripts/test.py: run_in_blender.py pytest_in_blender.py [pytest's options]"""

import sys

import pytest

if __name__ == "__main__":
    sys.exit(pytest.main(sys.argv[1:]))
