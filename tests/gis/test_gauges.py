"""Gauges: what flows past lines and points, and the files that they are given in."""

import csv
import json

import numpy as np
import pytest
import shapely

import snowmpm
from snowmpm.cli.app import app
from snowmpm.errors import InputError
from snowmpm.gis.asked import asked_of
from snowmpm.gis.layers import Layer
from snowmpm.gis.lines import MOST, read_places
from snowmpm.gis.vectors import write_geopackage
from snowmpm.io.gauges import MOST_POINTS, Place, gauges

pytest.importorskip("rasterio", reason="needs the extra gis")
CHANGES = {"solver.dx": 10.0, "end_time": 40.0, "output.interval": 1.0}


@pytest.fixture(scope="module", params=["volumes", "columns"])
def run(request, tmp_path_factory):
    scene = snowmpm.load_scene("avalanche_depth_averaged", {**CHANGES, "solver.depth.scheme": request.param})
    return snowmpm.run(scene, tmp_path_factory.mktemp("valley"))


def across(run, share, half=150.0):
    """Ends of a line across the thalweg of a run, at a share of its length."""
    profile = run.hazard["profile"]
    way = np.column_stack([profile["x"], profile["y"]])
    k = int(share * len(way))
    along = way[k + 2] - way[k - 2]
    normal = np.array([-along[1], along[0]]) / np.linalg.norm(along)
    return way[k] + half * np.array([[-1.0], [1.0]]) * normal


def beyond(run, line):
    """Volume [m3] that lies below a line at the end, less what lay there at the start, by the maps."""
    deposit, release = run.maps["deposit_depth"], run.maps["release_depth"]
    rows, columns = np.indices(deposit.values.shape)
    place = run.origin[:2] + deposit.cell * np.stack([columns, rows], axis=-1) + [deposit.x0, deposit.y0]
    along = line[1] - line[0]
    side = (place - line[0]) @ np.array([along[1], -along[0]])
    gain = np.nan_to_num(deposit.values) - np.nan_to_num(release.values)
    return deposit.cell**2 * float(gain[side > 0.0].sum())


@pytest.mark.parametrize("share", [0.3, 0.5, 0.7])
def test_the_volume_is_what_lies_beyond_the_line_at_the_end(run, share):
    line = across(run, share)
    assert gauges(run, [Place("line", line)])[0].numbers["gauge_volume"] == pytest.approx(beyond(run, line), rel=0.03)


def test_a_line_has_parts_and_no_direction(run):
    line = across(run, 0.5)
    whole, back, left, right = (one.numbers for one in gauges(run, [
        Place("whole", line), Place("back", line[::-1]), Place("left", np.array([line[0], line.mean(axis=0)])),
        Place("right", np.array([line.mean(axis=0), line[1]]))]))
    assert 0.5 * run.hazard["numbers"]["release_volume"] < whole["gauge_volume"]
    assert back["gauge_volume"] == pytest.approx(whole["gauge_volume"], rel=1e-9)  # whichever way it is drawn
    assert left["gauge_volume"] + right["gauge_volume"] == pytest.approx(whole["gauge_volume"], rel=5e-3)
    assert whole["gauge_frames"] == pytest.approx(whole["gauge_volume"], rel=0.08)  # frames, 1 s apart
    assert whole["gauge_both_ways"] == pytest.approx(whole["gauge_volume"], rel=0.01)


def test_series_and_profile_of_a_line(run):
    line = across(run, 0.5)
    one = gauges(run, [Place("road", line)])[0]
    series, numbers, profile = one.series, one.numbers, one.profile
    assert series["volume"][-1] == numbers["gauge_frames"]
    assert series["discharge"].max() == numbers["gauge_discharge"] > 0.0
    flows = series["time"][series["discharge"] > 0.02 * numbers["gauge_discharge"]]
    assert flows[0] == pytest.approx(numbers["gauge_arrival"], abs=2.0)
    assert numbers["gauge_duration"] > 5.0
    assert series["depth"].max() <= 1.02 * numbers["gauge_depth"]
    assert series["speed"].max() <= 1.02 * numbers["gauge_speed"]
    assert profile["s"][-1] == pytest.approx(np.linalg.norm(line[1] - line[0]), abs=5.0)
    assert np.nanmax(profile["peak_speed"]) == pytest.approx(numbers["gauge_speed"])


def test_a_point_and_a_line_beside_the_flow(run):
    middle = across(run, 0.5).mean(axis=0)
    numbers = run.hazard["numbers"]
    hut = gauges(run, [Place("hut", middle[None])])[0]
    assert hut.numbers["gauge_depth"] <= numbers["largest_flow_depth"] and hut.numbers["gauge_arrival"] > 0.0
    assert "discharge" not in hut.series and not hut.profile
    away = gauges(run, [Place("away", run.origin[None, :2] + [40.0, 15.0])])[0].numbers
    assert away["gauge_arrival"] is None and away["gauge_duration"] is None and away["gauge_depth"] == 0.0
    point = gauges(run, [Place("corner", 10.0 * np.round(middle[None] / 10.0))])[0]  # of four map cells
    assert point.series["speed"].max() <= 1.02 * point.numbers["gauge_speed"]
    with pytest.raises(InputError, match="'afar' lies beside the maps"):
        gauges(run, [Place("afar", middle[None] + 1e5)])


def written(path, features):
    path.write_text(json.dumps({"type": "FeatureCollection", "features": [
        {"type": "Feature", "properties": {} if name is None else {"name": name},
         "geometry": shapely.geometry.mapping(shape)} for name, shape in features]}), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def short(tmp_path_factory):
    scene = snowmpm.load_scene("avalanche_depth_averaged", {**CHANGES, "solver.dx": 20.0, "end_time": 20.0})
    return snowmpm.run(scene, tmp_path_factory.mktemp("short"))


def test_lines_and_points_are_read_from_files(short, tmp_path):
    shapely_line, point = shapely.LineString(across(short, 0.5)), shapely.Point(across(short, 0.5)[0])
    path = written(tmp_path / "g.geojson", [("road", shapely_line), (None, point), ("road", shapely_line),
                                            (None, shapely.MultiPoint([point, point]))])
    found = read_places(path, short)
    assert [one.name for one in found] == ["road 1", "point 1", "road 2", "point 2", "point 3"]
    np.testing.assert_allclose(found[0].corners, across(short, 0.5))
    pytest.importorskip("pyogrio")
    layer = Layer("huts", "Point", [(point, {"name": "hut"})])
    write_geopackage(tmp_path / "g.gpkg", [layer], short.provenance.get("crs"))
    assert [(one.name, one.is_line) for one in read_places(tmp_path / "g.gpkg", short)] == [("hut", False)]
    shapefile = pytest.importorskip("shapefile")
    for kind, name in ((shapefile.POINT, "p"), (shapefile.POLYLINE, "l"), (shapefile.MULTIPOINT, "m")):
        with shapefile.Writer(str(tmp_path / name), kind) as file:
            file.field("NAME", "C")
            {"p": lambda: file.point(*point.coords[0]), "l": lambda: file.line([across(short, 0.5).tolist()]),
             "m": lambda: file.multipoint([point.coords[0]] * 2)}[name]()
            file.record("mast")
        found = read_places(tmp_path / f"{name}.shp", short)
        assert [one.name for one in found] == {"m": ["mast 1", "mast 2"]}.get(name, ["mast"])
        assert all(one.is_line == (name == "l") for one in found)


@pytest.mark.parametrize(("shapes", "words"), [
    ([], "holds no line or point"), ([shapely.box(0, 0, 1, 1)], "holds no line or point"),
    ([shapely.LineString([(6e5, 2e5), (6e5, 2e5)])], "line 1 has no length"),
    ([shapely.Point(6e5, 2e5)] * (MOST + 1), f"at most {MOST}"),
])
def test_files_that_cannot_be_gauges(short, tmp_path, shapes, words):
    with pytest.raises(InputError, match=words):
        read_places(written(tmp_path / "g.geojson", [(None, one) for one in shapes]), short)


def test_gauges_of_one_name_are_told_apart(short, tmp_path):
    line, point = shapely.LineString(across(short, 0.5)), shapely.Point(across(short, 0.5)[0])
    path = written(tmp_path / "g.geojson", [("road", line), ("road", line), ("road 1", point)])
    names = [one.name for one in read_places(path, short)]
    assert len(set(names)) == 3 and "road 1" in names


def test_too_many_points_are_refused(short):
    line = across(short, 0.5)
    corners = np.linspace(line[0], line[1], MOST_POINTS + 1)
    for place in (Place("corners", corners), Place("length", line[0] + np.array([[0.0, 0.0], [1e9, 0.0]])),
                  Place("far", line[0] + np.array([[0.0, 0.0], [1e300, 0.0]]))):
        with pytest.raises(InputError, match=f"at most {MOST_POINTS}"):
            gauges(short, [place])


def test_frames_too_far_apart_are_told(tmp_path):
    scene = snowmpm.load_scene("avalanche_depth_averaged", {**CHANGES, "solver.dx": 20.0, "output.interval": 40.0})
    found = snowmpm.run(scene, tmp_path / "run")
    path = written(tmp_path / "g.geojson", [("road", shapely.LineString(across(found, 0.5)))])
    with pytest.warns(UserWarning, match="'road' the frames add up to another volume"):
        numbers = asked_of(found, gauges=path).gauges[0].numbers
    assert numbers["gauge_volume"] > 1e4


@pytest.mark.parametrize("scheme", ["volumes", "columns"])
def test_map_cells_finer_than_those_of_the_flow(tmp_path, scheme):
    """Every line of map cells sees the flow, whatever lies between the middles of its cells."""
    scene = snowmpm.load_scene("avalanche_depth_averaged", {**CHANGES, "output.map_cell": 5.0,
                                                            "solver.depth.scheme": scheme})
    found = snowmpm.run(scene, tmp_path)
    x = across(found, 0.5)[:, 0].mean() + np.array([0.0, 2.5, 5.0, 7.5, 10.0])
    lines = [np.array([[one, 200100.0], [one, 200400.0]]) for one in x]
    numbers = [one.numbers for one in gauges(found, [Place(f"{k}", line) for k, line in enumerate(lines)])]
    for one in numbers:
        assert one["gauge_frames"] == pytest.approx(one["gauge_volume"], rel=0.15)
    volumes = [one["gauge_volume"] for one in numbers]
    assert max(volumes) < 1.05 * min(volumes)


def test_maps_writes_gauges(short, tmp_path, capsys):
    path = written(tmp_path / "g.geojson", [("road", shapely.LineString(across(short, 0.5))),
                                            ("hut", shapely.Point(across(short, 0.5).mean(axis=0)))])
    with pytest.raises(SystemExit) as end:
        app(["maps", str(short.path.parent), "-o", str(tmp_path / "maps"), "--gauges", str(path)])
    assert not end.value.code
    told = capsys.readouterr().out
    assert "volume that passed" in told and "\nhut" in told
    with open(tmp_path / "maps" / "gauges.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert {row["gauge"] for row in rows} == {"road", "hut"} and len(rows) == 2 * len(short)
    assert all(row["discharge_m3_s"] == "" for row in rows if row["gauge"] == "hut")
    record = json.loads((tmp_path / "maps" / "avalanche.json").read_text(encoding="utf-8"))
    assert record["gauges"]["road"]["gauge_volume"]["unit"] == "m3"
    assert "gauge.road.gauge_discharge" in (tmp_path / "maps" / "avalanche.csv").read_text(encoding="utf-8")
    assert (tmp_path / "maps" / "gauges.png").is_file() and (tmp_path / "maps" / "gauge_profiles.csv").is_file()
    (tmp_path / "maps" / "gauges.csv").write_text("mine", encoding="utf-8")
    with pytest.raises(SystemExit):
        app(["maps", str(short.path.parent), "-o", str(tmp_path / "maps"), "-q"])
    # What an earlier call left is gone, but not what somebody changed
    assert "gauges.csv" in capsys.readouterr().err and (tmp_path / "maps" / "gauges.png").is_file()
    (tmp_path / "maps" / "gauges.csv").unlink()
    with pytest.raises(SystemExit):
        app(["maps", str(short.path.parent), "-o", str(tmp_path / "maps"), "-q"])
    assert not (tmp_path / "maps" / "gauges.png").exists()


def test_the_geopackage_holds_gauges(short, tmp_path):
    path = written(tmp_path / "g.geojson", [("road", shapely.LineString(across(short, 0.5))),
                                            ("hut", shapely.Point(across(short, 0.5).mean(axis=0)))])
    with pytest.raises(SystemExit):
        app(["maps", str(short.path.parent), "-o", str(tmp_path / "maps"), "--gauges", str(path), "-q"])
    import pyogrio

    layers = pyogrio.list_layers(tmp_path / "maps" / "avalanche.gpkg")
    assert {"gauge_lines", "gauge_points"} <= {name for name, _ in layers}


def test_gauges_need_more_than_pictures(short, tmp_path, capsys):
    with pytest.raises(SystemExit) as end:
        app(["maps", str(short.path.parent), "-o", str(tmp_path / "maps"), "--files", "pictures", "--gauges",
             "g.geojson"])
    assert end.value.code == 2 and "--gauges: not with --files pictures" in capsys.readouterr().err


def test_numbers_along_a_path_of_one_s_own(short, tmp_path, capsys):
    """One that goes on beyond the thalweg; one that ends in the flow is told, one beside the maps refused."""
    profile = short.hazard["profile"]
    way = np.column_stack([profile["x"], profile["y"]])
    further = np.vstack([way, way[-1] + np.array([150.0, 0.0])])

    def called(line):
        path = written(tmp_path / "way.geojson", [(None, shapely.LineString(line))])
        with pytest.raises(SystemExit) as end:
            app(["maps", str(short.path.parent), "-o", str(tmp_path / "maps"), "--path", str(path)])
        said = capsys.readouterr()
        return end.value.code, said.out, said.err

    code, told, _ = called(further)
    assert not code and "along way.geojson" in told and "at its end" not in told
    record = json.loads((tmp_path / "maps" / "avalanche.json").read_text(encoding="utf-8"))
    assert record["path"] == "way.geojson"
    assert 0.0 < record["along_path"]["path_runout"]["value"] < shapely.LineString(further).length
    code, told, _ = called(way[: len(way) // 2])
    assert not code and "above 1 kPa at its end" in told
    code, _, refused = called(way + 1e5)
    assert code == 2 and "lies beside the maps" in refused
