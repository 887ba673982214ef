"""Every block of code of README and guides runs: Python as it stands but smaller, shell with shorter runs.

`docs/python.md` has a test of its own (`test_documentation.py`), the tutorial too (`test_tutorial.py`). Blocks marked
`text` are output, or a part of something.
"""

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import snowmpm
from snowmpm.scenes import library, load_scene
from tests.support.project import ROOT

GUIDES = [ROOT / "README.md", *sorted(path for folder in ("docs", "scenes", "materials")
                                      for path in (ROOT / folder).glob("*.md"))]

ELSEWHERE = {"README.md", "python.md", "TUTORIAL.md"}
"""Guides whose Python or shell has a test of its own: README's two commands are those of `.ci/run`."""

SMALLER = {
    "campaigns.md": {"runs=50": "runs=4", "set={": 'set={"solver.dx": 20.0, '},
}
"""What is changed of a guide's Python for a quick test."""


def blocks(guide, *languages):
    return [block for language, block in re.findall(r"^```(\w*)\n(.*?)^```", guide.read_text(encoding="utf-8"),
                                                    re.DOTALL | re.MULTILINE) if language in languages]


def name_of(path):
    return path.relative_to(ROOT).as_posix()


def test_languages_of_blocks_are_known():
    """So that none is left out: shell, Python, scenes; output and parts of something are text."""
    known = {"sh", "python", "toml", "text"}
    block = re.compile(r"^```(\w*)\n.*?^```", re.DOTALL | re.MULTILINE)
    found = {(name_of(guide), language) for guide in [*GUIDES, ROOT / "CONTRIBUTING.md"]
             for language in block.findall(guide.read_text(encoding="utf-8"))}
    assert sorted(pair for pair in found if pair[1] not in known) == []


@pytest.fixture
def run_of_a_block(tmp_path, monkeypatch):
    """A folder with a short run in 3-D, under the names that guides use."""
    monkeypatch.chdir(tmp_path)
    run = snowmpm.run(load_scene(ROOT / "tests" / "cli" / "block.toml"), "runs/slab")
    shutil.copytree(run.path.parent, "runs/slab_release")


PYTHON = [guide for guide in GUIDES if blocks(guide, "python") and guide.name not in {*ELSEWHERE, "plugins.md"}]
SLOW = {"micro.md", "campaigns.md"}
"""Grains that are compressed one by one; a campaign with workers of its own."""


@pytest.mark.parametrize("guide", [
    pytest.param(guide, marks=[pytest.mark.slow] if guide.name in SLOW else [], id=name_of(guide)) for guide in PYTHON])
def test_python_of_a_guide_runs(guide, run_of_a_block, capsys):
    """From top to bottom, in one program."""
    names = {"__name__": "__main__"}
    text = blocks(guide, "python")
    for old, new in SMALLER.get(guide.name, {}).items():
        assert any(old in block for block in text), old
        text = [block.replace(old, new) for block in text]
    for block in text:
        exec(block, names)


def test_a_law_of_one_s_own_is_used_as_the_guide_says(tmp_path):
    """The file `my_law.py`, and the two commands with it; in a process of its own, since laws are registered."""
    guide = ROOT / "docs" / "plugins.md"
    (tmp_path / "my_law.py").write_text(blocks(guide, "python")[0], encoding="utf-8")
    shell("snowmpm new scene --set solver.dx=0.4 --set end_time=0.1", tmp_path)
    text = (tmp_path / "scene.toml").read_text(encoding="utf-8")
    sand = '[materials.\\1]\nkind = "my_sand"\ndensity = 250.0\nyoungs_modulus = 1e6\npoisson_ratio = 0.3\n'
    own = re.sub(r"\[materials\.(\w+)\].*?(?=\n\[)", sand, text, count=1, flags=re.DOTALL)
    assert own != text
    (tmp_path / "scene.toml").write_text(own, encoding="utf-8")
    for line in blocks(guide, "sh")[0].splitlines():
        shell(line, tmp_path)
    assert (tmp_path / "runs" / "scene" / "run.vtkhdf").exists()


def shell(line, folder):
    """Run a line of a guide, with this Python's programs."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(["bash", "-c", line], cwd=folder, env={**os.environ, "PATH": path}, capture_output=True,
                          text=True, timeout=3000, stdin=subprocess.DEVNULL)
    assert done.returncode == 0, f"{line}\n{done.stdout[-2000:]}\n{done.stderr[-2000:]}"
    return done.stdout


SHELL = [guide for guide in GUIDES if blocks(guide, "sh") and guide.name not in {*ELSEWHERE, "plugins.md"}]

NOT_HERE = re.compile(r"/path/|HOST|seen\.shp|--install-completion|^pip |^dask |SNOWMPM_COMPILER"
                      r"|event:|events score|calibrate fit\.toml|line\.shp|pit\.xml|pits/|pit_profile|^qgis_process"
                      r"|^snowmpm release runs/")
"""Places and files for the reader's own, what changes the machine, other programs, files from a network. Commands on
profiles have tests of their own in tests/pit, QGIS in tests/integrations."""

GIVEN = {
    "runs/avalanche_on_raster": "avalanche_on_raster --set solver.dx=3",
    **dict.fromkeys(("runs/slab_release_2d", "runs/a", "runs/b"), "slab_release_2d --set solver.dx=0.1"),
    **dict.fromkeys(("runs/slab_release", "runs/release"), "slab_release --set solver.dx=0.4"),
}
"""Runs that guides take as given: the reader has computed them before."""


def small_campaign(name, folder):
    """A campaign of the library with four runs on larger cells, as a file of the folder."""
    text = (ROOT / "scenes" / "library" / "campaigns" / f"{name}.toml").read_text(encoding="utf-8")
    small = re.sub(r"^runs = \d+", "runs = 4", text, flags=re.MULTILINE)
    small = small.replace('"solver.dx" = 10.0', '"solver.dx" = 20.0')
    (folder / f"{name}.toml").write_text(small, encoding="utf-8")


def shorter(line, folder):
    """A line whose runs end after two frames, and whose campaigns are small."""
    parts = []
    for part in line.split(" && "):
        words = shlex.split(part, comments=True)
        if words[0] not in ("snowmpm", "cp"):
            parts.append(part)  # as it stands: it may write to a file
            continue
        if words[:2] == ["snowmpm", "run"] and "--question" not in words:  # a question is answered by a whole run
            words[2] = str(ROOT / words[2]) if words[2].startswith("docs/") else words[2]
            scene = load_scene(words[2]) if words[2] in library() or words[2].startswith(str(ROOT)) else None
            interval = min(scene.output.interval, scene.end_time / 4) if scene else 0.05
            words += ["--set", f"end_time={2 * interval}", "--set", f"output.interval={interval}"]
            words += [] if "--resume" in words else ["--overwrite"]
        elif words[:3] == ["snowmpm", "campaign", "run"]:
            small_campaign(words[3], folder)
            words[3:4] = [f"{words[3]}.toml", "-o", f"campaigns/{words[3]}"]
        elif words[1] in ("render", "plot", "report", "export", "maps", "new"):
            words += ["--overwrite"]
        if "--time" in words:  # given runs end at 0.5 s, runs of the guide itself after two frames
            words[words.index("--time") + 1] = "0.2"
        if words[:1] == ["cp"]:
            words[1] = str(ROOT / words[1])
        if words[:2] == ["snowmpm", "micro"]:
            words[2] = str(ROOT / words[2])
        parts.append(shlex.join(words))
    return " && ".join(parts)


@pytest.mark.slow
@pytest.mark.parametrize("guide", SHELL, ids=name_of)
def test_shell_of_a_guide_runs(guide, tmp_path):
    """From top to bottom in an empty folder, with shorter runs; what a guide takes as given is there."""
    text = "".join(blocks(guide, "sh"))
    for run, scene in GIVEN.items():
        if run in text:
            shell(f"snowmpm run {scene} -o {run} --set end_time=0.5 --set output.interval=0.1", tmp_path)
    for line in text.replace("\\\n", " ").splitlines():
        if line.strip() and not NOT_HERE.search(line):
            shell(shorter(line, tmp_path), tmp_path)
