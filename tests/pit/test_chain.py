"""`snowmpm chain`: what it refuses before anything is written, and, slow, all of it on the made-up pit and valley."""

import json
from dataclasses import replace

import pytest

from snowmpm.pit import chain as steps
from snowmpm.pit.chain import Chain, Variation
from snowmpm.pit.reader import read_profile
from snowmpm.pit.stability import Stability
from snowmpm.pit.weak_layers import candidates
from tests.support.project import ROOT
from tests.support.snow_pits import write

PIT, VALLEY = ROOT / "docs" / "snow_pit.csv", ROOT / "scenes" / "library" / "valley.asc"
PLACE = (600180.0, 200260.0)


def test_the_pit_of_the_guide_has_its_weak_layer():
    read = read_profile(PIT)
    assert read.layers[candidates(read)[0].index].form == "DH"


def test_the_local_slope_is_that_of_the_raster():
    slope = steps.slope_at(VALLEY, PLACE, 14.0)
    height = slope.surface.height
    east = (height([[PLACE[0] + 14.0, PLACE[1]]]) - height([[PLACE[0] - 14.0, PLACE[1]]]))[0] / 28.0
    north = (height([[PLACE[0], PLACE[1] + 14.0]]) - height([[PLACE[0], PLACE[1] - 14.0]]))[0] / 28.0
    assert slope.down @ [east, north] == pytest.approx(-((east**2 + north**2) ** 0.5))
    assert 30.0 < slope.angle < 45.0


def _begun(tmp_path, place=PLACE, **more):
    read = read_profile(PIT)
    found = candidates(read)
    return steps.begin(read, found, found[0].index, VALLEY, place, tmp_path, **more)


def test_the_angle_is_the_local_one_and_the_patch_large_enough_to_tear(tmp_path):
    found = _begun(tmp_path)
    assert found.column.angle == found.slope.angle != 38.0
    assert found.side == pytest.approx(steps.SIZE * found.column.thickness, rel=0.1)
    assert _begun(tmp_path, size=50.0).side == 50.0


@pytest.mark.parametrize(("words", "message"), [
    (("--at", "600180"), "--at = '600180': must be X,Y"),
    (("--at", "0,0"), "--at 0,0: not on the terrain, which knows x from"),
    (("--at", "600800,200260"), "no release on"),
    (("--at", "600180,200260", "--size", "1"), "--size = 1.0: must be from 2 to 400 m"),
    (("--at", "600180,200260", "--modulus", "wood"), "--modulus = 'wood'"),
    (("--at", "600180,200260", "--layer", "400"), "--layer = 400.0"),
    (("--at", "nan,200260"), "--at = 'nan,200260'"),
    (("--at", "600180,200260", "--layer", "103"), "weak layer at 101 cm, --at 600180,200260: no scenes: no law gives"),
    (("--at", "600180,200260", "--size", "390"), "the terrain ends, or has a hole, within"),
])
def test_refused_and_nothing_written(cli, tmp_path, words, message):
    done = cli("chain", str(PIT), "--terrain", str(VALLEY), "-o", str(tmp_path / "out"), *words)
    assert done.exit_code == 2
    assert message in done.output
    assert not (tmp_path / "out").exists()


def test_a_broken_pit_and_a_missing_raster_are_refused(cli, tmp_path):
    broken = write(tmp_path, text="<a>")
    for pit, terrain, message in ((broken, VALLEY, "not valid XML"), (PIT, tmp_path / "none.asc", "no such file")):
        done = cli("chain", str(pit), "--terrain", str(terrain), "--at", "600180,200260", "-o", str(tmp_path / "out"))
        assert done.exit_code == 2
        assert message in done.output
        assert not (tmp_path / "out").exists()


def _chain(folder, *variations, **more):
    stability = Stability(1.0, 1.0, (), 1.0, "", None)
    return Chain(None, [], 0, None, stability, None, 1.0, folder, {}, variations=variations, **more)


def test_the_step_that_counts_most_is_the_one_with_the_widest_change(tmp_path):
    found = _chain(
        tmp_path, Variation("as found", "-", "", {"runout": 500.0}), Variation("a", "x", "friction", {"runout": 540.0}),
        Variation("b", "x", "area", {"runout": 470.0}), Variation("c", "x", "area", {"runout": 520.0}),
        Variation("d", "x", "thickness", {"runout": None}),
        Variation(steps.WHOLE_SLOPE, "all ground", "area", {"runout": 900.0}))
    assert found.spread() == {"friction": (0.0, 40.0), "area": (-30.0, 20.0)}
    assert found.dominant == ("area", -30.0, 20.0)
    first, second = found.dependence()
    assert "how large the release is" in first and "500 m from the square" in first and "900 m from all ground" in first
    assert "depends most on area: -30 to +20 m" in second


def test_a_chain_whose_slab_does_not_go_has_no_dependence(tmp_path):
    found = _chain(tmp_path, why="it released nothing")
    assert found.dominant is None and found.whole is None and found.dependence() == []


def test_pit_and_terrain_that_do_not_agree_are_told(tmp_path):
    read = replace(read_profile(PIT), elevation=2500.0, slope_angle=20.0)
    found = steps.begin(read, candidates(read), 4, VALLEY, PLACE, tmp_path)
    assert [text[:7] for text in found.notes] == ["the pit", "the pit"]
    assert "2500 m, and the terrain there is at 14" in found.notes[0]
    assert _begun(tmp_path).notes == ()


def test_the_area_is_varied_by_its_factor():
    import shapely

    area = shapely.box(0.0, 0.0, 30.0, 20.0)
    for factor in (2.0, 0.5):
        corners = steps.resized(area, factor)["bodies.0.shape.region"]["polygon"]
        assert shapely.Polygon(corners).area == pytest.approx(factor * area.area, rel=0.03)


@pytest.mark.slow
def test_a_slab_that_does_not_go_still_has_its_report(cli, tmp_path):
    """Six metres of weak layer: the firm snow around holds the slab."""
    done = cli("chain", str(PIT), "--terrain", str(VALLEY), "--at", "600180,200260", "--size", "6", "-o",
               str(tmp_path / "out"))
    assert done.exit_code == 0, done.output
    assert "the slab did not go" in done.output
    assert json.loads((tmp_path / "out" / "chain.json").read_text(encoding="utf-8"))["release"] is None
    assert "The slab did not go" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_chain_from_the_pit_to_the_map(cli, tmp_path):
    """The slab goes, its flow comes to rest, and the page says what counts most."""
    out = tmp_path / "out"
    done = cli("chain", str(PIT), "--terrain", str(VALLEY), "--at", "600180,200260", "-o", str(out))
    assert done.exit_code == 0, done.output
    values = json.loads((out / "chain.json").read_text(encoding="utf-8"))
    assert values["release"]["area"] == pytest.approx(values["size"] ** 2, rel=0.15)
    assert values["release"]["thickness"] == pytest.approx(values["stability"]["slab"]["thickness"], rel=0.1)
    runouts = {one["name"]: one["runout"] for one in values["variations"]}
    guide = (ROOT / "docs" / "snow_pits.md").read_text(encoding="utf-8")
    # Of the guide; round-off moves the border of the release by a cell, the run-outs by a map cell of 10 m
    assert "release 510 m²" in guide and values["release"]["area"] == pytest.approx(510.0, rel=0.03)
    assert "(403 to 968 m)" in guide and runouts["as found"] == pytest.approx(403.0, abs=10.0)
    assert runouts["whole_slope"] == pytest.approx(968.0, abs=20.0)
    assert len(values["variations"]) == 8
    assert "how large the release is" in values["dependence"][0]
    page = (out / "report.html").read_text(encoding="utf-8")
    for words in ("depends most on how large the release is", "Every assumption, and its source", "Jamieson"):
        assert words in page
    assert (out / "maps" / "peak_pressure.tif").is_file()
    for scene in ("saw_test.toml", "release.toml", "flow.toml"):
        assert cli("check", str(out / scene)).exit_code == 0
