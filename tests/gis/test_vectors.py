"""Vector files, read back: layers, fields, places, projections."""

import json

import numpy as np
import pyproj
import pytest
import shapely

from snowmpm.errors import InputError
from snowmpm.gis import layers_of, write_geojson, write_geopackage, write_project
from snowmpm.gis.observed import Observed, read_observed
from tests.support.straight_avalanche import LAMBERT, lambert, write_avalanche


def read(path, layer):
    """(meta, geometries, {field: values}) of one layer."""
    import pyogrio

    meta, _, geometry, values = pyogrio.raw.read(str(path), layer=layer)
    return meta, shapely.from_wkb(geometry), dict(zip(meta["fields"], values, strict=True))


def test_geopackage_holds_every_layer(straight, tmp_path):
    import pyogrio

    seen = Observed("seen.shp", shapely.box(247100.0, 352080.0, 247300.0, 352120.0))
    layers = layers_of(straight, seen)
    path = write_geopackage(tmp_path / "avalanche.gpkg", layers, straight.provenance["crs"])
    assert {name for name, _ in pyogrio.list_layers(path)} == {layer.name for layer in layers}
    for layer in layers:
        meta, geometries, fields = read(path, layer.name)
        assert pyproj.CRS(meta["crs"]).to_epsg() == LAMBERT
        assert meta["geometry_type"].removesuffix(" Z") == layer.geometry_type
        assert len(geometries) == len(layer.features) and all(fields["final"])
        for found, (geometry, values) in zip(geometries, layer.features, strict=True):
            assert shapely.equals_exact(found, geometry, 0.0)
            assert fields["run"][0] == values["run"] == "straight"
    assert [entry.name for entry in tmp_path.iterdir()] == ["avalanche.gpkg"]
    fields = read(path, "runout_point")[2]
    assert fields["runout"][0] == straight.hazard["numbers"]["runout"] and fields["parameter_grid_spacing"][0] == "2 m"


def test_obstacles_and_dams_are_layers(straight, tmp_path, monkeypatch):
    house = shapely.box(247200.0, 352090.0, 247210.0, 352100.0)
    line = np.array([[247300.0, 352080.0], [247300.0, 352120.0]])
    monkeypatch.setattr("snowmpm.gis.layers.footprints", lambda run: {"house": house})
    monkeypatch.setattr("snowmpm.gis.layers.dam_lines", lambda run: {"dam": line})
    path = write_geopackage(tmp_path / "avalanche.gpkg", layers_of(straight), straight.provenance["crs"])
    for layer, name, size in (("obstacles", "house", house.area), ("dams", "dam", 0.0)):
        _, geometries, fields = read(path, layer)
        assert fields["name"].tolist() == [name] and geometries[0].area == size
    project = write_project(tmp_path / "avalanche.qgs", straight, layers_of(straight), path.name).read_text()
    assert 'name="dams"' in project and 'name="obstacles"' in project


def test_open_classes_have_no_upper_limit(tmp_path, straight):
    layers = [layer for layer in layers_of(straight) if layer.name == "pressure_classes"]
    (geometry, fields) = layers[0].features[-1]
    layers[0].features.append((geometry, {**fields, "to_kpa": None}))
    path = write_geopackage(tmp_path / "a.gpkg", layers)
    values = read(path, "pressure_classes")[2]["to_kpa"]
    assert values[:2].tolist() == [10.0, 100.0] and np.isnan(values[2])


def test_geojson_says_where_it_is_and_is_read_again(straight, tmp_path):
    path = write_geojson(tmp_path / "a.geojson", layers_of(straight), straight.provenance["crs"])
    record = json.loads(path.read_text())
    assert record["crs"]["properties"]["name"] == f"urn:ogc:def:crs:EPSG::{LAMBERT}"
    names = [feature["properties"]["layer"] for feature in record["features"]]
    assert names.count("pressure_classes") == 2 and names.count("runout_point") == 1
    point = next(f for f in record["features"] if f["properties"]["layer"] == "runout_point")
    assert point["geometry"]["coordinates"][0] == pytest.approx(straight.hazard["numbers"]["runout_x"], abs=0.006)
    assert point["properties"]["final"] is True
    one = {"type": "FeatureCollection", "crs": record["crs"], "features": record["features"][:1]}
    (tmp_path / "outline.geojson").write_text(json.dumps(one))
    again = read_observed(tmp_path / "outline.geojson", straight)
    assert again.geometry.area == pytest.approx(straight.hazard["numbers"]["affected_area"])


def test_a_projection_without_a_code_becomes_longitude_and_latitude(straight, tmp_path):
    own = pyproj.CRS.from_proj4("+proj=tmerc +lat_0=47 +lon_0=11.1 +x_0=247200 +y_0=352000 +ellps=GRS80 +units=m")
    path = write_geojson(tmp_path / "a.geojson", layers_of(straight), own.to_wkt())
    record = json.loads(path.read_text())
    assert "CRS84" in record["crs"]["properties"]["name"]
    x, y = record["features"][-1]["geometry"]["coordinates"][:2]
    assert x == pytest.approx(11.1, abs=0.02) and y == pytest.approx(47.0, abs=0.02)
    assert record["features"][-1]["geometry"]["coordinates"][2] == pytest.approx(800.0, abs=1.0)


def test_no_geojson_without_a_projection(straight, tmp_path):
    """Read elsewhere, metres would be degrees."""
    with pytest.raises(InputError, match="needs a coordinate system"):
        write_geojson(tmp_path / "b.geojson", layers_of(straight), None)
    assert not list(tmp_path.iterdir())


def test_an_outline_is_read_from_a_geopackage(straight, tmp_path):
    outlines = [layer for layer in layers_of(straight) if layer.name == "affected_area"]
    for name, crs in (("own", straight.provenance["crs"]), ("plain", None)):
        path = write_geopackage(tmp_path / f"{name}.gpkg", outlines, crs)
        area = read_observed(path, straight).geometry.area
        assert area == pytest.approx(straight.hazard["numbers"]["affected_area"])
    several = write_geopackage(tmp_path / "several.gpkg", layers_of(straight), straight.provenance["crs"])
    with pytest.raises(InputError, match="holds 4 layers of polygons, affected_area"):
        read_observed(several, straight)
    (tmp_path / "other.gpkg").write_text('<OGRVRTDataSource><OGRVRTLayer name="own"/></OGRVRTDataSource>')
    with pytest.raises(InputError, match="not a readable GeoPackage"):
        read_observed(tmp_path / "other.gpkg", straight)


def test_a_run_without_outlines_is_refused(tmp_path):
    from snowmpm.io import Run, RunWriter

    with RunWriter(tmp_path, provenance={}) as writer:
        writer.map("peak_depth", np.ones((3, 3)), 0.0, 0.0, 1.0, "m")
    with pytest.raises(InputError, match="no outlines"):
        layers_of(Run(tmp_path))


def test_what_is_not_final_says_so_in_every_feature(tmp_path):
    run = write_avalanche(tmp_path, moving=0.98, crs=lambert())
    for layer in layers_of(run):
        for _, fields in layer.features:
            assert fields["final"] is False and "98 % of the snow is faster than 1 m/s" in fields["status"]
