"""A component is one folder and one name in a list: in a copy of the program without them all else works as before."""

import os
import re
import runpy
import shutil
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

from snowmpm import components
from snowmpm.scenes import load_scene
from snowmpm.scenes.library import library
from tests.support.project import ROOT

FOLDERS = {"snowmpm": "snowmpm", "materials": "snowmpm/materials", "scenes": "snowmpm/scenes",
           "render": "snowmpm/render", "docs": "snowmpm/guides"}

PROGRAM = """
import sys

import snowmpm.registry
from snowmpm import components
from snowmpm.advice.report import advise
from snowmpm.cli.app import app
from snowmpm.scenes import load_scene
from snowmpm.scenes.messages import schema_of
from snowmpm.scenes.schema import Scene
from snowmpm.study.atlas.catalogue import ENTRIES

assert sys.argv[1] not in components.NAMES and sys.argv[1] not in snowmpm.registry.COMPONENTS
assert schema_of(Scene)["title"] == "Scene" and ENTRIES
for name in sys.argv[2:]:
    assert load_scene(name).name
advise(load_scene("oedometer"))
try:
    app(["list"])
except SystemExit as end:
    assert not end.code
"""


def without(component, folder):
    """A copy of the program without a component."""
    for source, target in FOLDERS.items():
        shutil.copytree(ROOT / source, folder / target, dirs_exist_ok=True,
                        ignore=shutil.ignore_patterns("__pycache__", "gallery", "figures"))
    package = folder / "snowmpm" / "components"
    shutil.rmtree(package / component)
    names = package / "__init__.py"
    lines = names.read_text(encoding="utf-8").splitlines(keepends=True)
    kept = [line for line in lines if not line.startswith(f'    "{component}": (')]
    assert len(kept) == len(lines) - 1
    names.write_text("".join(kept), encoding="utf-8")


def uses(name, component):
    """Whether a library scene asks for a component, or for one that builds on it."""
    return any(component in (one.name, *components.NAMES[one.name]) for one in components.used(load_scene(name)))


@pytest.mark.parametrize("component", components.NAMES)
def test_the_program_works_without_it(component, tmp_path):
    without(component, tmp_path)
    scenes = [name for name in library() if not uses(name, component)]
    done = subprocess.run([sys.executable, "-c", textwrap.dedent(PROGRAM), component, *scenes], cwd=tmp_path,
                          env={**os.environ, "PYTHONPATH": str(tmp_path)}, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr[-3000:]
    assert len(scenes) > 30


@pytest.mark.parametrize("component", components.NAMES)
def test_nothing_outside_its_folder_names_it(component):
    """Beside the list of names, components that build on it, and tables of measured costs and borders. Names count,
    words in prose do not."""
    counted = runpy.run_path(ROOT / ".ci" / "structure.py")["named_in"]
    own = ROOT / "snowmpm" / "components"
    above = [own / component, *(own / other for other, needed in components.NAMES.items() if component in needed)]
    for folder in ("snowmpm", "scenes", "materials", "render"):
        for path in (ROOT / folder).rglob("*.py"):
            if path != own / "__init__.py" and not any(path.is_relative_to(one) for one in above):
                assert not counted(path.read_text(encoding="utf-8"), component), path.relative_to(ROOT)


@pytest.mark.slow
@pytest.mark.parametrize("component", components.NAMES)
def test_scenes_and_methods_are_as_before_without_it(component, tmp_path):
    """`check` of all scenes that do not use it, and the contract of the methods."""
    without(component, tmp_path)
    tests = shutil.copytree(ROOT / "tests", tmp_path / "tests", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.rmtree(tests / "components" / component)
    shutil.copytree(ROOT / "docs", tmp_path / "docs", ignore=shutil.ignore_patterns("figures"))
    for file in ("pyproject.toml", "README.md"):
        shutil.copy(ROOT / file, tmp_path)
    surroundings = {**os.environ, "PYTHONPATH": str(tmp_path)}
    for name in (name for name in library() if not uses(name, component)):
        done = subprocess.run([sys.executable, "-m", "snowmpm", "check", name], cwd=tmp_path, env=surroundings,
                              capture_output=True, text=True, timeout=300)
        assert done.returncode == 0, (name, done.stderr)
    done = subprocess.run([sys.executable, "-m", "pytest", "-q", "-n", "2", "tests/contract"], cwd=tmp_path,
                          env=surroundings, capture_output=True, text=True, timeout=3000)
    assert done.returncode == 0, done.stdout[-3000:]


@pytest.mark.parametrize("component", components.declared(), ids=lambda component: component.name)
def test_it_declares_without_the_compiler(component):
    text = (ROOT / Path(*component.package.split(".")) / "declare.py").read_text(encoding="utf-8")
    imported = [line.split()[1] for line in text.splitlines() if line.startswith(("import ", "from "))]
    assert not [name for name in imported if name.startswith(("taichi", "snowmpm.compiler", "snowmpm.mpm",
                                                              "snowmpm.sph", "snowmpm.depth", "snowmpm.implicit"))]


@pytest.mark.parametrize("component", components.declared(), ids=lambda component: component.name)
def test_what_it_does_not_go_with_is_known(component):
    from snowmpm.setup.refusals import FEATURES

    assert all(name in FEATURES or re.fullmatch(r'[a-z_.]+( = "[a-z_0-9]+")?', name) for name in component.beside)
    assert any(component.supports(method) for method in ("mpm", "sph", "depth", "implicit"))
    assert not component.supports("no_such_method")
