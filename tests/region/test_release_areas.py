"""Release areas of whole rasters: areas and attributes that are known, tiles, forest, and files."""

import numpy as np
import pytest
import shapely

from snowmpm.region import release_areas as areas_of
from snowmpm.region.elevations import as_geotiff, open_elevations
from snowmpm.region.forest import open_forest
from snowmpm.region.release_terrain import RULES, Rule
from snowmpm.seeding.regions import read_regions
from tests.support.region import ROOF, roof

RARE = RULES["rare"]


def test_a_roof_has_two_areas_that_face_away(raster):
    with open_elevations(raster(roof())) as elevations:
        found = areas_of.release_areas(elevations, ROOF)
    assert len(found) == 2
    assert sorted(round(one.aspect) for one in found) == [90, 270]
    for one in found:
        assert one.slope == pytest.approx(36.0, abs=0.5)
        assert one.surface == pytest.approx(one.area / np.cos(np.radians(one.slope)), rel=0.01)
        assert one.geometry.area == pytest.approx(one.area, rel=1e-12)
        assert one.lowest < one.altitude < one.highest
    assert not found[0].geometry.intersection(found[1].geometry).area


@pytest.mark.parametrize("tile", [37, 64])
def test_tiles_do_not_show(terrain, monkeypatch, tile):
    """The same ground can release, however it is cut into tiles, and no area ends at the border of one."""
    with open_elevations(terrain) as elevations:
        whole = areas_of.release_areas(elevations, RARE)
        monkeypatch.setattr(areas_of, "TILE", tile)
        cut = areas_of.release_areas(elevations, RARE)
    one, other = (shapely.union_all([area.geometry for area in found]) for found in (whole, cut))
    # Small areas are left out, and which are small depends a little on the order of merging
    assert one.symmetric_difference(other).area < 0.03 * one.area
    assert abs(len(whole) - len(cut)) < 0.2 * len(whole)
    border = shapely.MultiLineString([[(600_000.0 + 10.0 * tile * k, 0.0), (600_000.0 + 10.0 * tile * k, 9e5)]
                                      for k in range(1, 400 // tile + 1)])
    assert sum(border.crosses(area.geometry) for area in cut) > 2


def test_forest_protects(raster, tmp_path):
    file = raster(roof())
    forest = tmp_path / "forest.geojson"
    forest.write_text('{"type": "FeatureCollection", "crs": {"type": "name", "properties": {"name":'
                      ' "urn:ogc:def:crs:EPSG::21781"}}, "features": [{"type": "Feature", "properties": {}, "geometry":'
                      ' {"type": "Polygon", "coordinates": [[[600000, 200000], [600300, 200000], [600300, 200600],'
                      ' [600000, 200600], [600000, 200000]]]}}]}')
    with open_elevations(file) as elevations, open_forest(forest, elevations.grid) as trees:
        found = areas_of.release_areas(elevations, ROOF, trees)
        cut = areas_of.release_areas(elevations, ROOF, trees, protects=False)
    assert [round(one.aspect) for one in found] == [90] and found[0].forest == 0.0
    assert sorted(round(one.forest) for one in cut) == [0, 1]


@pytest.mark.parametrize("system", ["EPSG:21781", "EPSG:2056"])
def test_forest_as_a_raster_in_another_system(raster, system):
    """Crown cover on other cells, also of another coordinate system."""
    file = raster(roof())
    shift = (2_000_000.0, 1_000_000.0) if system == "EPSG:2056" else (0.0, 0.0)
    cover = np.zeros((60, 60))
    cover[:, 30:] = 80.0
    woods = raster(cover, cell=10.0, name="cover.tif", system=system,
                   corner=(600_000.0 + shift[0], 200_000.0 + shift[1]))
    with open_elevations(file) as elevations, open_forest(woods, elevations.grid, 50.0) as trees:
        found = areas_of.release_areas(elevations, ROOF, trees)
    assert [round(one.aspect) for one in found] == [270]


def test_the_file_is_a_release_of_a_flow(raster, tmp_path):
    from dataclasses import replace

    with open_elevations(raster(roof())) as elevations:
        found = [replace(one, thickness=1.25) for one in areas_of.release_areas(elevations, ROOF)]
        file = areas_of.write(found, tmp_path / "areas.gpkg", "rare", elevations.grid.system)
        system = elevations.grid.system
    regions = read_regions(file, "test", system)
    assert [one.thickness for one in regions] == [1.25, 1.25]
    assert sum(one.area() for one in regions) == pytest.approx(sum(one.area for one in found))


def test_an_ascii_grid_gives_the_same(raster, tmp_path):
    z = roof(60)
    rows = "\n".join(" ".join(f"{h:.4f}" for h in row) for row in z)
    grid = tmp_path / "ground.asc"
    grid.write_text(f"ncols 60\nnrows 60\nxllcorner 600000\nyllcorner 200000\ncellsize 5\nNODATA_value -9999\n{rows}\n")
    results = []
    for file in (raster(z, system=None), as_geotiff(grid, tmp_path)):
        with open_elevations(file) as elevations:
            results.append(areas_of.release_areas(elevations, ROOF))
    assert [one.area for one in results[0]] == [one.area for one in results[1]]


def test_memory_does_not_grow_with_the_raster(raster, monkeypatch):
    """What is read at a time is a tile and its halo."""
    monkeypatch.setattr(areas_of, "TILE", 32)
    read = []
    with open_elevations(raster(roof())) as elevations:
        own = elevations.read
        monkeypatch.setattr(elevations, "read", lambda rows, columns: read.append(
            (rows[1] - rows[0]) * (columns[1] - columns[0])) or own(rows, columns))
        areas_of.release_areas(elevations, RARE)
    assert max(read) <= 48**2 and len(read) == 16


def test_bounds_of_size(raster):
    with open_elevations(raster(roof())) as elevations:
        small = areas_of.release_areas(elevations, Rule(least=28.0, mean=28.0, largest=10_000.0, smallest=5000.0))
    assert len(small) > 10
    assert all(5000.0 <= one.area <= 10_000.0 for one in small)
