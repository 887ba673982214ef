"""The fork of Taichi that would take its place (`docs/taichi_forks.md`): default tests by its kernels."""

import importlib.util
import os
import subprocess
import sys

import pytest

from snowmpm.compiler import backend
from tests.support.project import ROOT

PARTS = ("contract", "mpm/test_every_transfer.py mpm/test_conservation.py components/body_contact", "materials",
         "depth verification/test_depth_block.py", "sph", "implicit water",
         "components/structures components/rigid_bodies saw_test",
         "resume seeding components/forcing_and_damping", "test_scenes_run.py")
"""Folders and files of tests/."""


def test_the_parts_are_there():
    assert [place for part in PARTS for place in part.split() if not (ROOT / "tests" / place).exists()] == []


def test_the_name_of_a_compiler_is_checked():
    done = subprocess.run([sys.executable, "-m", "snowmpm", "check", "pst_2d"], cwd=ROOT, capture_output=True,
                          text=True, env={**os.environ, backend.VARIABLE: "numba"}, timeout=60)
    assert done.returncode == 2
    assert done.stderr == "error: SNOWMPM_COMPILER=numba: must be one of taichi, quadrants, taichi_forge\n"


@pytest.mark.skipif(importlib.util.find_spec("taichi_forge") is not None, reason="taichi-forge is installed")
def test_a_compiler_that_is_not_installed_is_named():
    done = subprocess.run([sys.executable, "-m", "snowmpm", "check", "pst_2d"], cwd=ROOT, capture_output=True,
                          text=True, env={**os.environ, backend.VARIABLE: "taichi_forge"}, timeout=60)
    assert done.returncode == 2
    assert done.stderr == "error: SNOWMPM_COMPILER=taichi_forge: is not installed; pip install taichi-forge\n"


@pytest.mark.slow
@pytest.mark.skipif(importlib.util.find_spec("quadrants") is None, reason="quadrants is in the extra of that name")
@pytest.mark.parametrize("part", PARTS)
def test_default_tests_pass_on_quadrants(part):
    words = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--tb=short"]
    done = subprocess.run([*words, *(f"tests/{place}" for place in part.split())], cwd=ROOT, text=True,
                          capture_output=True, env={**os.environ, backend.VARIABLE: "quadrants"})
    assert done.returncode == 0, done.stdout[-3000:]
