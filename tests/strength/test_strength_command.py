"""`snowmpm strength`: what it prints and leaves, on a coarse grid, and what it refuses."""

import csv
import json

import numpy as np
import pytest

from snowmpm.cli.app import app
from snowmpm.render.figure import ENDINGS

STRONG = ["--set", "materials.soil.cohesion=9e3", "--set", "materials.soil.friction_angle=33"]
COARSE = ["--set", "solver.dx=1.0", *STRONG]


def call(capsys, *arguments):
    """Exit code and what was printed of `snowmpm strength`."""
    with pytest.raises(SystemExit) as end:
        app(["strength", *arguments])
    return end.value.code, capsys.readouterr()


@pytest.mark.slow
def test_a_slope_from_the_library(tmp_path, capsys):
    """Bishop's factor is 1.59; on cells of 1 m, six over the height, the slope holds itself up a little longer."""
    code, said = call(capsys, "slope_failure", *COARSE, "--step", "0.5", "-o", str(tmp_path / "out"))
    assert code == 0, said.err
    numbers = json.loads((tmp_path / "out" / "strength.json").read_text())
    assert 1.5 <= numbers["factor_of_safety"] <= 2.5 and numbers["bishop"] == pytest.approx(1.59, abs=0.01)
    assert numbers["factor_of_safety"] - numbers["stands_at"] == pytest.approx(0.5)
    assert 0.05 < numbers["share_that_slides"] < 0.8
    rows = list(csv.DictReader((tmp_path / "out" / "search.csv").open()))
    for row in rows:
        factor = float(row["factor"])
        assert (row["verdict"] == "slides") == (factor >= numbers["factor_of_safety"])
        assert (float(row["speed [m/s]"]) > numbers["speed_limit"]) == (row["verdict"] == "slides")
        assert float(row["soil.cohesion"]) == pytest.approx(9e3 / factor)
        assert np.tan(np.radians(float(row["soil.friction_angle"]))) == pytest.approx(0.6494 / factor, rel=1e-3)
        assert (tmp_path / "out" / row["run"] / "run.vtkhdf").is_file()
    surface = np.loadtxt(tmp_path / "out" / "slip_surface.csv", delimiter=",", skiprows=1)
    assert (surface[:, 1] > 0.0).all() and (surface[:, 1] < 9.0).all()
    assert (tmp_path / "out" / f"strength{ENDINGS[0]}").stat().st_size > 10_000
    assert f"factor of safety  {numbers['factor_of_safety']:g}" in " ".join(said.out.split("\n")) or (
        f"{numbers['factor_of_safety']:g} (slides" in said.out)


@pytest.mark.parametrize(("arguments", "words"), [
    (["--step", "0"], "--step"), (["--from", "2", "--to", "1"], "--from"), (["--duration", "0"], "--duration"),
    (["--material", "mud"], "--material = 'mud': must be a material of"),
    (["--set", "gravity=0.0"], "gravity"),
])
def test_what_is_refused(arguments, words, tmp_path, capsys):
    code, said = call(capsys, "slope_failure", *COARSE, *arguments, "-o", str(tmp_path / "out"))
    assert code == 2 and words in said.err and said.err.count("\n") <= 2 and "Traceback" not in said.err
    assert not (tmp_path / "out").exists()


def test_nothing_to_weaken(tmp_path, capsys):
    code, said = call(capsys, "elastic_beam", "-o", str(tmp_path / "out"))
    assert code == 2 and "none has a strength" in said.err
