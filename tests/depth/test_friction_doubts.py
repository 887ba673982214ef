"""A class of ground friction that does not hold where the flow came to rest is told of after the run."""

import numpy as np
import pytest

import snowmpm
from snowmpm.io.remarks import remarks
from snowmpm.running.friction_class import doubts_after
from snowmpm.scenes import Scene


def scene(folder, altitude, card):
    """A slab on a slope that runs out on the flat, at an altitude [m]."""
    x = np.arange(80) * 1.0
    row = altitude + 0.7 * np.maximum(0.0, 30.0 - x)
    head = "ncols 80\nnrows 20\nxllcorner 0\nyllcorner 0\ncellsize 1\nNODATA_value -9999\n"
    file = folder / "slope.asc"
    file.write_text(head + "\n".join([" ".join(f"{z:.3f}" for z in row)] * 20) + "\n")
    return Scene.model_validate({
        "name": "doubted", "dimension": 3, "end_time": 6.0, "output": {"interval": 2.0},
        "solver": {"method": "depth", "dx": 1.0},
        "terrain": {"kind": "dem", "file": str(file), "friction": card if isinstance(card, float) else {"card": card}},
        "materials": {"snow": {"kind": "elastic", "density": 200.0, "youngs_modulus": 1e6, "poisson_ratio": 0.3}},
        "bodies": [{"name": "slab", "material": "snow",
                    "shape": {"kind": "layer", "top": 1.0, "region": {"x": [3.0, 15.0], "y": [4.0, 16.0]}}}]})


@pytest.mark.parametrize(("altitude", "rests"), [(2000.0, True), (900.0, False)])
def test_it_is_told_after_the_run(tmp_path, altitude, rests):
    """samosAT's small and medium classes are for a run-out below 1600 m, the medium one for 25 000 m3 and more."""
    run = snowmpm.run(scene(tmp_path, altitude, "samos_at_medium"), tmp_path / "run")
    told = " ".join(remarks(run))
    assert ("samos_at_medium: the flow rests at 2000 m" in told) == rests
    assert "samos_at_medium: the release has" in told


def test_numbers_of_ones_own_are_not_judged(tmp_path):
    model = snowmpm.Simulation(scene(tmp_path, 2000.0, 0.3)).model
    assert doubts_after(model, {"runout_z": 2000.0}) == []
