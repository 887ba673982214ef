"""The thickness among the attributes of vector files: other names, other text, and what is wrong with a value."""

import json

import numpy as np
import pytest

from snowmpm.errors import InputError
from snowmpm.seeding import seed_body
from snowmpm.seeding.attributes import thickness_of
from snowmpm.seeding.region_files import read_features
from snowmpm.seeding.shapefiles import code_page
from snowmpm.terrain import load_terrain
from tests.support.tables import Table as Spec

shapefile = pytest.importorskip("shapefile")
pyogrio = pytest.importorskip("pyogrio")

SQUARES = [[[x, 1.0], [x, 9.0], [x + 8.0, 9.0], [x + 8.0, 1.0], [x, 1.0]]
           for x in (1.0, 11.0, 21.0)]


def written(path, fields, rows, encoding="cp1252", language=0):
    """A shapefile of a square for each row. fields: (name, type, size, decimals); language: byte 29 of the table."""
    with shapefile.Writer(str(path), encoding=encoding) as writer:
        for field in fields:
            writer.field(*field)
        for corners, row in zip(SQUARES, rows, strict=False):
            writer.poly([corners])
            writer.record(*row)
    table = path.with_suffix(".dbf")
    data = bytearray(table.read_bytes())
    data[29] = language
    table.write_bytes(data)
    path.with_suffix(".cpg").unlink(missing_ok=True)
    return path


def geojson(path, rows, **more):
    features = [{"type": "Feature", "properties": row, "geometry": {"type": "Polygon", "coordinates": [corners]}}
                for corners, row in zip(SQUARES, rows, strict=False)]
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features, **more}), encoding="utf-8")
    return path


def geopackage(path, rows, field):
    import shapely

    polygons = shapely.polygons([np.array(corners) for corners in SQUARES[: len(rows)]])
    pyogrio.raw.write(path, shapely.to_wkb(polygons), [np.array(rows, object)], [field], geometry_type="Polygon",
                      driver="GPKG", crs="EPSG:32632", layer="release")
    return path


NAME, THICK = ("Gebiet", "C", 20), ("thickness", "N", 8, 2)


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("cpg", [None, "UTF-8", "1252", "nonsense", "", "\ufeffé"])
@pytest.mark.parametrize("encoding", ["cp1252", "cp850", "utf-8"])
def test_text_that_is_not_needed_does_not_matter(tmp_path, encoding, cpg):
    path = written(tmp_path / "release.shp", [NAME, THICK], [["Gürtel Nord é", 0.6], ["Süd", 0.8]], encoding)
    if cpg is not None:
        path.with_suffix(".cpg").write_text(cpg, encoding="utf-8")
    assert [one.thickness for one in read_features(path, "file")] == [0.6, 0.8]


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize(("encoding", "language", "cpg"), [
    ("cp1252", 0x57, None), ("cp1252", 0x03, None), ("cp850", 0x02, None), ("cp1252", 0x02, "1252"),
    ("cp1252", 0, "ANSI 1252"), ("iso8859-1", 0, "88591"), ("utf-8", 0, None), ("utf-8", 0x57, "UTF-8")])
def test_code_page_is_that_of_the_file(tmp_path, encoding, language, cpg):
    fields = [("Mächtig", "N", 8, 2), NAME]
    path = written(tmp_path / "release.shp", fields, [[0.7, "Gürtel"]], encoding, language)
    if cpg:
        path.with_suffix(".cpg").write_text(cpg)
    assert code_page(path.with_suffix(".dbf")) == encoding
    assert [one.thickness for one in read_features(path, "file", None, "mächtig")] == [0.7]


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("spoil", ["missing", "cut", "empty", "noise"])
def test_polygons_without_a_readable_table_are_read(tmp_path, spoil):
    path = written(tmp_path / "release.shp", [NAME, THICK], [["a", 0.6], ["b", 0.8]])
    table = path.with_suffix(".dbf")
    data = table.read_bytes()
    if spoil == "missing":
        table.unlink()
    else:
        table.write_bytes({"cut": data[:40], "empty": b"", "noise": bytes(range(256)) * 4}[spoil])
    features = read_features(path, "file")
    assert len(features) == 2 and features[0].thickness is None and "has no attribute 'thickness'" in features[0].flaw


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_capital_suffixes_and_deleted_rows(tmp_path):
    path = written(tmp_path / "release.shp", [NAME, THICK], [["a", 0.6], ["b", 0.8], ["c", 0.9]])
    table = path.with_suffix(".dbf")
    data = bytearray(table.read_bytes())
    first = int.from_bytes(data[8:10], "little")
    data[first + int.from_bytes(data[10:12], "little")] = ord("*")  # row 2 is deleted
    table.write_bytes(data)
    for one in (path, table, path.with_suffix(".shx")):
        one.rename(one.with_suffix(one.suffix.upper()))
    features = read_features(path.with_suffix(".SHP"), "file")
    assert [one.thickness for one in features] == [0.6, 0.9]


@pytest.mark.parametrize(("value", "thickness", "flaw"), [
    (0.6, 0.6, ""), (1, 1.0, ""), ("0.6", 0.6, ""), (" 0.6 ", 0.6, ""), (np.float32(0.5), 0.5, ""),
    (None, None, "is missing"), ("", None, "is missing"), (float("nan"), None, "is missing"),
    ("1,2", None, "= '1,2': must be a number of metres; with a point: 1.2"),
    ("1,2,3", None, "= '1,2,3': must be a number of metres"), ("two", None, "= 'two': must be a number of metres"),
    (True, None, "= True: must be a number of metres"), ([1], None, "= [1]: must be a number of metres"),
    (0.0, None, "= 0: must be above 0 and at most 100 m"), (-1.2, None, "= -1.2: must be above 0 and at most 100 m"),
    (-9999, None, "= -9999: must be above 0 and at most 100 m"),
    (150, None, "= 150: must be above 0 and at most 100 m"),
    (float("inf"), None, "= inf: must be above 0 and at most 100 m"), (10**400, None, None)])
def test_values(value, thickness, flaw):
    said = thickness_of(value)
    assert said == (thickness, flaw) if flaw is not None else said[0] is None and said[1]


@pytest.mark.parametrize("kind", ["shp", "geojson", "gpkg"])
@pytest.mark.filterwarnings("ignore::UserWarning")
def test_one_missing_value_is_told_by_its_polygon(tmp_path, kind):
    path = tmp_path / f"release.{kind}"
    if kind == "shp":
        written(path, [THICK], [[0.6], [None]])
    elif kind == "geojson":
        geojson(path, [{"Thickness": 0.6}, {"thickness": None}])
    else:
        geopackage(path, [0.6, None], "thickness")
    features = read_features(path, "file")
    assert features[0].thickness == 0.6
    assert (features[1].thickness, features[1].flaw.lower()) == (None, "polygon 2: thickness is missing")


@pytest.mark.parametrize("kind", ["shp", "geojson", "gpkg"])
def test_the_older_name_is_read(tmp_path, kind):
    path = tmp_path / f"release.{kind}"
    if kind == "shp":
        written(path, [NAME, ("D0", "N", 8, 2)], [["a", 0.6]])
    elif kind == "geojson":
        geojson(path, [{"name": "a", "d0": 0.6}])
    else:
        geopackage(path, [0.6], "d0")
    assert [one.thickness for one in read_features(path, "file")] == [0.6]


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_another_name_is_given_or_told(tmp_path):
    geojson(tmp_path / "release.geojson", [{"name": "a", "depth": 0.6}])
    assert [one.thickness for one in read_features(tmp_path / "release.geojson", "file", None, "Depth")] == [0.6]
    for attribute in (None, "height"):
        flaw = read_features(tmp_path / "release.geojson", "file", None, attribute)[0].flaw
        assert flaw == f"has no attribute {attribute or 'thickness'!r} (its attributes are name, depth)"


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_bytes_before_and_in_geojson(tmp_path):
    path = geojson(tmp_path / "release.geojson", [{"name": "Gurtel", "thickness": 0.6}])
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes().replace(b"Gurtel", b"G\xfcrtel"))
    assert [one.thickness for one in read_features(path, "file")] == [0.6]


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize(("rows", "words"), [
    ([{"thickness": "1,2"}], "polygon 1: thickness = '1,2': must be a number of metres; with a point: 1.2: mend"),
    ([{"thickness": 1.2}, {"thickness": -1.2}], "polygon 2: thickness = -1.2: must be above 0 and at most 100 m: mend"),
    ([{"depth": 1.2}], r"has no attribute 'thickness' \(its attributes are depth\): name another with attribute"),
    ([{}], r"has no attribute 'thickness' \(it has none\)")])
def test_a_layer_says_what_is_wrong(tmp_path, rows, words):
    geojson(tmp_path / "release.geojson", rows)
    plane = load_terrain(Spec(kind="plane", point=(0.0, 0.0, 50.0), angle=30.0), extent=([0, 0], [40, 40]))
    spec = Spec(kind="layer", bottom=0.0, top="file", region=Spec(file="release.geojson"), attribute=None)
    with pytest.raises(InputError, match=words):
        seed_body(spec, plane, dim=3, dx=0.5, particles_per_cell=8, sampling="regular",
                  rng=np.random.default_rng(1), base_dir=tmp_path)


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_the_name_as_it_is_written_comes_before_others(tmp_path):
    path = geojson(tmp_path / "release.geojson", [{"Thickness": 5.0, "thickness": 1.0}])
    for attribute, value in ((None, 1.0), ("thickness", 1.0), ("Thickness", 5.0)):
        assert read_features(path, "file", None, attribute)[0].thickness == value


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_truth_and_marks_between_digits_are_no_thickness(tmp_path):
    import shapely

    assert thickness_of("1_5")[0] is None
    pyogrio.raw.write(tmp_path / "truth.gpkg", shapely.to_wkb(shapely.polygons([np.array(SQUARES[0])])),
                      [np.array([True])], ["thickness"], geometry_type="Polygon", driver="GPKG", crs="EPSG:32632",
                      layer="release")
    assert "must be a number" in read_features(tmp_path / "truth.gpkg", "file")[0].flaw


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_all_parts_of_a_collection_are_read(tmp_path):
    import shapely

    whole = shapely.GeometryCollection([shapely.MultiPolygon([shapely.Polygon(ring) for ring in SQUARES])])
    pyogrio.raw.write(tmp_path / "all.gpkg", shapely.to_wkb(np.array([whole])), [np.array([1.0])], ["thickness"],
                      geometry_type="Unknown", driver="GPKG", crs="EPSG:32632", layer="release")
    assert len(read_features(tmp_path / "all.gpkg", "file")[0].parts) == 3
