"""The slope mesh of the scene library."""

from pathlib import Path

import numpy as np

from snowmpm.terrain import load_terrain
from snowmpm.terrain.generate import slope_mesh
from tests.support.tables import Table as Spec

FILE = Path(__file__).parents[2] / "scenes" / "library" / "slope.stl"


def test_regenerating_gives_the_shipped_file():
    made = slope_mesh()
    kept = load_terrain(Spec(kind="mesh", file=str(FILE)))
    assert FILE.stat().st_size <= 1_000_000
    assert len(made.faces) == len(kept.facets)
    rows = [v[np.lexsort((v[:, 1], v[:, 0]))] for v in (made.vertices, kept.vertices)]
    assert np.abs(rows[0] - rows[1]).max() < 4e-6  # float32 in the file: half an ulp of 60 m is 2e-6 m


def test_it_is_an_avalanche_slope():
    surface = load_terrain(Spec(kind="mesh", file=str(FILE)))
    x = surface.vertices[surface.facets].mean(axis=1)[:, 0]
    dip = np.degrees(np.arccos(surface.facet_normals[:, 2]))
    assert not surface.closed
    assert 38.0 < np.median(dip[x < 15]) < 40.5  # release area
    assert dip.max() < 48.0
    assert (dip[x > 47] < 6.0).all()  # run-out
    bend = surface.vertex_normals[surface.facets]
    cosine = np.einsum("fki,fi->fk", bend, surface.facet_normals).min()
    assert np.degrees(np.arccos(cosine)) < 5.0  # smooth: ... by a few degrees (measured 4.2)
