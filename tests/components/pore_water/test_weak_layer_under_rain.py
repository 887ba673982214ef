"""Rain that percolates to a weak layer: the slab slides once water takes the cohesion there, and not before."""

import numpy as np
import pytest

from snowmpm.running.simulation import Simulation
from snowmpm.scenes import load_scene
from snowmpm.water.permeability import Calonne, relative_permeability
from tests.support.project import ROOT

SCENE = ROOT / "docs" / "rain_on_slope.toml"
RATE, START, RESIDUAL, DENSITY = 16.0, 0.5, 0.07, 350.0
LAYERS = (("base", 0.0, 0.2), ("weak", 0.2, 0.4), ("slab", 0.4, 0.6))
END = 5.0


def layered(weakening):
    """`Simulation` of three layers on the slope; water takes cohesion of the middle one alone."""
    snow = load_scene(SCENE).materials["snow"].model_dump(exclude_none=True)
    strong = {**snow, "water_weakening": 0.0}
    return Simulation(load_scene(SCENE, {
        "materials": {"strong": strong, "weak": {**snow, "cohesion": 1e3, "water_weakening": weakening}},
        "events": [{"kind": "rain", "rate": RATE, "start": START}], "end_time": END,
        "bodies": [{"name": name, "material": "weak" if name == "weak" else "strong",
                    "shape": {"kind": "layer", "bottom": bottom, "top": top, "region": {"x": [3.0, 8.0]}}}
                   for name, bottom, top in LAYERS]}))


def speeds(simulation):
    """Mean speed of the slab [m/s] at times 0.05 s apart: (times, speeds)."""
    found, numbers = [], simulation.numbers_of_body(2)
    for time in np.arange(0.05, END, 0.05):
        while simulation.time < time:
            simulation.step(until=time)
        fields = simulation.particles
        slab = (fields["id"] >= numbers[0]) & (fields["id"] < numbers[1])
        found.append((time, np.linalg.norm(fields["velocity"][slab].mean(axis=0))))
    assert simulation.audit()["water_residual"] < 1e-10
    return np.array(found).T


def arrival(depth):
    """When the front [s] is at this depth below the surface, normal to it, by the kinematic wave of Colbeck."""
    porosity = 1.0 - DENSITY / 917.0
    conductivity = Calonne(law="calonne", grain_size=4e-3).of(porosity) * 1000.0 * 9.81 / 1.792e-3
    share = np.linspace(RESIDUAL, 1.0, 10001)
    wet = np.interp(RATE / 1000.0 / conductivity, relative_permeability(share), share)
    return START + depth / np.cos(np.radians(38.0)) * porosity * (wet - RESIDUAL) * 1000.0 / RATE


@pytest.mark.slow
def test_the_slab_slides_once_water_is_in_the_weak_layer():
    """What the water leaves of the cohesion, exp(-23.5 0.2), is below what the weight asks for: the layer fails as the
    front runs through it, which grids smear over a cell and a half. Then friction alone holds the slab back:
    a = g (sin 38 - cos 38 tan 33), 1.02 m/s2."""
    time, speed = speeds(layered(23.5))
    slope, friction = np.radians((38.0, 33.0))
    alone = 9.81 * (np.sin(slope) - np.cos(slope) * np.tan(friction))
    growth = (speed[4:] - speed[:-4]) / (time[4:] - time[:-4])
    slides = time[2:-2][growth > 0.5 * alone][0]
    assert arrival(0.2) < slides < arrival(0.4)
    assert growth[-1] == pytest.approx(alone, rel=0.1)


@pytest.mark.slow
def test_it_stays_where_water_takes_no_cohesion():
    """The weight of the rain alone brings nothing down."""
    _, speed = speeds(layered(0.0))
    assert speed.max() < 0.01
