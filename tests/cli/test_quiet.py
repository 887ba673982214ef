"""`--quiet` says less, and leaves the same files."""

from pathlib import Path

import pytest

import snowmpm
from snowmpm.cli.app import app

BLOCK = Path(__file__).with_name("block.toml")
COARSE = {"solver.dx": 20.0, "solver.particles_per_cell": 2, "end_time": 16.0, "output.interval": 8.0}
CASES = {
    "run": f"run {BLOCK} -o out --backend cpu",
    "picture": "render FLAT -o out/p.png --time 0 --size 160x100",
    "film": "render FLAT -o out/p.mp4 --size 160x100",
    "pictures in a folder": "render FLAT -o out --size 160x100",
    "stills": "render FLAT -o out/p.jpg --stills 2 --size 320x100",
    "report": "report FLAT -o out/r.html --still",
    "maps, pictures": "maps DEEP -o out --files pictures",
    "export": "export FLAT -o out --as ply",
}
LONG = {
    "run with its film": f"run {BLOCK} -o out --backend cpu --render",
    "page": "render DEEP -o out/p.html",
    "maps": "maps DEEP -o out",
    "maps over time": "maps DEEP -o out --over-time gif",
    "report, pages": "report FLAT -o out/r.pdf --still",
}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("made")
    snowmpm.run(snowmpm.load_scene(BLOCK), folder / "flat")
    snowmpm.run(snowmpm.load_scene("avalanche_depth_averaged", COARSE), folder / "deep")
    return folder


LONG_ONES = [pytest.param(one, marks=pytest.mark.slow) for one in LONG.values()]


@pytest.mark.parametrize("words", [*CASES.values(), *LONG_ONES],
                         ids=[*CASES, *LONG])
def test_quiet_leaves_the_same_files(words, made, tmp_path, monkeypatch, capsys):
    words, found = words.replace("FLAT", str(made / "flat")).replace("DEEP", str(made / "deep")).split(), []
    for quiet in ([], ["-q"]):
        here = tmp_path / ("quiet" if quiet else "said")
        here.mkdir()
        monkeypatch.chdir(here)
        with pytest.raises(SystemExit) as ended:
            app([*words, *quiet])
        said = capsys.readouterr()
        assert not ended.value.code, said.err
        assert not quiet or said.out == ""
        found.append({str(path.relative_to(here)) for path in here.rglob("*") if path.is_file()})
    assert found[0] and found[0] == found[1]
