"""Water that cannot be: exit code 2 and two lines, in every scheme, from `check` and from `run`."""

from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
SEEPING, MIXED = str(DOCS / "rain_on_slope.toml"), str(DOCS / "dam_break_two_phases.toml")
MOVING, SLUSH = "slush_dam_2d", "slushflow"


@pytest.mark.parametrize(("scene", "setting"), [
    (SEEPING, "water.permeability=0"), (SEEPING, "water.permeability=-1e-9"), (SEEPING, "water.porosity=1.2"),
    (SEEPING, "water.porosity=-0.1"), (SEEPING, "materials.snow.density=917"),
    (MOVING, "water.permeability=0"), (MOVING, "water.permeability=-1e-9"), (MOVING, "water.grain_density=400"),
    (MOVING, "materials.snow.density=917"),
    (SLUSH, "water.porosity=1.2"), (SLUSH, "water.porosity=-0.1"), (SLUSH, "materials.snow.density=917"),
    (MIXED, "water.drag.permeability=0"), (MIXED, "water.grain_density=900"), (MIXED, "materials.debris.density=2500"),
])
def test_water_that_cannot_be(call, tmp_path, scene, setting):
    """Permeability zero or negative, porosity outside 0 to 1, and a material without room for water."""
    for command in (("check", scene), ("run", scene, "-o", str(tmp_path / "out"))):
        refused = call(*command, "--set", setting)
        assert refused.code == 2, refused
        before, _, error = refused.err.partition("error: ")  # the valley's raster has holes, which it warns of
        assert error and error.count("\n") <= 2 and "Traceback" not in before + error
        assert setting.partition("=")[0].rpartition(".")[0] in error
    assert not (tmp_path / "out").exists()
