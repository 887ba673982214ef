"""The commands as a user gives them, each a process of its own."""

import json
import subprocess
import sys

import pytest

from snowmpm.region import massif

pytest.importorskip("distributed")


def snowmpm(*words, code=0):
    done = subprocess.run([sys.executable, "-m", "snowmpm", *map(str, words)], capture_output=True, text=True)
    assert done.returncode == code, done.stderr[-2000:]
    assert "Traceback" not in done.stderr
    return done


def test_run_resume_and_more_releases(tmp_path, region_file, scheduler):
    """On a raster large enough for overviews. A larger choice adds to a smaller one."""
    massif.write(tmp_path / "large.tif", side=6000.0, cell=10.0, seed=4)
    path = region_file()
    text = path.read_text().replace("massif.tif", "large.tif").replace("most_releases = 4", "most_releases = 2")
    path.write_text(text)
    out = tmp_path / "out"
    check = json.loads(snowmpm("check", path, "--json").stdout)
    assert check["runs"] == 2 and 0.05 < check["seconds_each"] < 20.0
    assert "euros of cloud" in snowmpm("check", path).stdout
    first = json.loads(snowmpm("region", path, "-o", out, "--scheduler", scheduler, "--json").stdout)
    assert first["scenarios"]["rare"]["done"] == 2
    before = (out / "results.jsonl").read_text()
    snowmpm("region", path, "-o", out, "--scheduler", scheduler, "--resume", "-q")
    assert (out / "results.jsonl").read_text() == before
    path.write_text(text.replace("most_releases = 2", "most_releases = 3"))
    more = json.loads(snowmpm("region", path, "-o", out, "--scheduler", scheduler, "--resume", "--json").stdout)
    assert more["scenarios"]["rare"]["done"] == 3 and (out / "results.jsonl").read_text().startswith(before)
    assert "already holds a region" in snowmpm("region", path, "-o", out, code=2).stderr


def test_release_areas(tmp_path, terrain):
    told = json.loads(snowmpm("release-areas", terrain, "-o", tmp_path / "a.gpkg", "--three-day-snow", 1.4,
                              "--json").stdout)
    assert len(told["areas"]) > 20 and all(one["thickness"] > 0.1 for one in told["areas"])
    said = snowmpm("release-areas", terrain, "-o", tmp_path / "b.gpkg", "--scenario", "extreme")
    assert "release areas of" in said.stdout and "no thickness" in said.stderr
    assert "must be one of frequent, rare, extreme" in snowmpm("release-areas", terrain, "--scenario", "often",
                                                               code=2).stderr
    assert "must end in .gpkg" in snowmpm("release-areas", terrain, "-o", tmp_path / "c.shp", code=2).stderr
    assert "no such file" in snowmpm("release-areas", tmp_path / "none.tif", code=2).stderr
