"""The outline of the release: of its polygons, or what its particles cover."""

import numpy as np
import pytest
import shapely

from snowmpm.setup.release_plan import covered


@pytest.mark.parametrize("turn", [0.0, 25.0])
def test_particles_cover_the_area_that_they_were_cut_from(turn):
    """A sheet of 40 m by 20 m with a hole of 8 m by 8 m, particles a metre apart, jittered by a quarter."""
    spacing, rng = 1.0, np.random.default_rng(3)
    plan = np.stack(np.meshgrid(np.arange(0.5, 40.0), np.arange(0.5, 20.0), indexing="ij"), axis=-1).reshape(-1, 2)
    plan = plan[~((np.abs(plan - [16.0, 10.0]) < 4.0).all(axis=1))] + rng.uniform(-0.25, 0.25, 2)
    plan = plan + rng.uniform(-0.25, 0.25, plan.shape)
    angle = np.radians(turn)
    area = covered(plan @ [[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]] + 2e5, spacing)
    perimeter = 120.0 + 32.0
    assert area.area == pytest.approx(800.0 - 64.0, abs=0.2 * spacing * perimeter)
    part, = shapely.get_parts(area)
    assert len(part.interiors) == 1
