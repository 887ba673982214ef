"""Water that cannot be: exit code 2 and two lines, in every scheme, from `check` and from `run`."""

from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
SEEPING, MIXED = str(DOCS / "rain_on_slope.toml"), str(DOCS / "dam_break_two_phases.toml")
MOVING, SLUSH = "slush_dam_2d", "slushflow"
SOLVED, AT_REST = str(DOCS / "terzaghi_column.toml"), str(DOCS / "rockfill_dam.toml")


@pytest.mark.parametrize(("scene", "setting"), [
    (SEEPING, "water.permeability=0"), (SEEPING, "water.permeability=-1e-9"), (SEEPING, "water.porosity=1.2"),
    (SEEPING, "water.porosity=-0.1"), (SEEPING, "materials.snow.density=917"),
    (MOVING, "water.permeability=0"), (MOVING, "water.permeability=-1e-9"), (MOVING, "water.grain_density=400"),
    (MOVING, "materials.snow.density=917"),
    (SOLVED, "water.permeability=0"), (SOLVED, "water.permeability=-1e-9"), (SOLVED, "water.porosity=1.2"),
    (SOLVED, "water.porosity=-0.1"), (SOLVED, "water.porosity=0"),
    (AT_REST, "water.permeability=0"), (AT_REST, "water.permeability=-1e-9"), (AT_REST, "water.grain_density=1000"),
    (AT_REST, "materials.rockfill.density=2600"),
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


@pytest.mark.parametrize(("line", "allowed"), [
    ("permeability = 0.0", "must be > 0"), ("permeability = -1e-9", "must be > 0"),
    ("permeability = nan", "must be a finite number"), ("permeability = inf", "must be a finite number"),
    ('permeability = "wet"', "must be a number"), ("permeability = true", "must be a number"),
    ("permeability = [1.0]", "must be a number"), ("porosity = 1.2", "must be < 1"), ("porosity = 0", "must be > 0"),
    ("porosity = nan", "must be a finite number"), ('porosity = "half"', "must be a number"),
])
def test_a_file_of_ones_own(call, tmp_path, line, allowed):
    """The message names file, key and value, and says what is allowed."""
    text, key = (DOCS / "terzaghi_column.toml").read_text(encoding="utf-8").splitlines(), line.partition(" =")[0]
    scene = tmp_path / "mine.toml"
    scene.write_text("\n".join(line if old.startswith(f"{key} =") else old for old in text), encoding="utf-8")
    refused = call("check", str(scene))
    assert refused.code == 2 and refused.err.count("\n") <= 2, refused
    value = line.partition("= ")[2].replace("-1e-9", "-1e-09")
    for part in ("mine.toml", f"water.{key} = {value}", allowed):
        assert part in refused.err
