"""The wheel: everything in it, nothing beside `snowmpm`."""

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FOLDERS = {
    "snowmpm": "snowmpm",
    "materials": "snowmpm/materials",
    "scenes": "snowmpm/scenes",
    "render": "snowmpm/render",
    "docs": "snowmpm/guides",
}


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """Wheel of a copy of the sources: a build leaves its traces where it builds."""
    source, target = tmp_path_factory.mktemp("source"), tmp_path_factory.mktemp("wheel")
    for folder in FOLDERS:
        shutil.copytree(ROOT / folder, source / folder, ignore=shutil.ignore_patterns("__pycache__"))
    for file in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / file, source)
    # Without isolation: the build needs no network, as setuptools is among the development requirements.
    command = [
        sys.executable,
        "-m",
        "pip",
        "wheel",
        "--no-deps",
        "--no-build-isolation",
        "-w",
        str(target),
        str(source),
    ]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    (built,) = target.glob("*.whl")
    return built


def names(wheel):
    with zipfile.ZipFile(wheel) as archive:
        return set(archive.namelist())


def test_every_module_and_scene_is_in_the_wheel(wheel):
    expected = {
        f"{inside}/{path.relative_to(ROOT / folder).as_posix()}"
        for folder, inside in FOLDERS.items()
        for path in (ROOT / folder).rglob("*")
        if path.is_file() and not {"__pycache__", "gallery", "figures", "notebooks", "paper"} & set(path.parts)
    }
    assert any(name.endswith(".stl") for name in expected)
    assert expected - names(wheel) == set()


def test_only_one_import_name_is_claimed(wheel):
    tops = {name.split("/")[0] for name in names(wheel)}
    assert {top for top in tops if not top.endswith(".dist-info")} == {"snowmpm"}
    assert len(tops) == 2
    assert not {name for name in names(wheel) if "test" in Path(name).parts}


def test_command_licence_and_python_are_declared(wheel):
    with zipfile.ZipFile(wheel) as archive:
        info = {Path(name).name: archive.read(name).decode() for name in archive.namelist() if ".dist-info/" in name}
    assert "snowmpm = snowmpm.cli:main" in info["entry_points.txt"]
    assert "License-Expression: MIT" in info["METADATA"]
    assert "MIT License" in info["LICENSE"]
    assert "Provides-Extra: gis" in info["METADATA"]


def test_installed_wheel_works_away_from_the_sources(wheel, tmp_path):
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tmp_path)
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    code = "from snowmpm.scenes.library import FOLDER; print(FOLDER)"
    for arguments in (["-c", code], ["-m", "snowmpm", "list"]):
        done = subprocess.run(
            [sys.executable, *arguments], capture_output=True, text=True, cwd=tmp_path, env=environment, timeout=60
        )
        assert done.returncode == 0, done.stderr
        if arguments[0] == "-c":
            assert Path(done.stdout.split()[-1]) == tmp_path / "snowmpm" / "scenes" / "library"
