"""Entries: granular flow on a slope, too shallow for the grid or too deep for its law.

Without friction and dilation by the same angle, frictional plasticity is ill-posed: in plastic flow some waves of its
equations of motion have no speed but a rate of growth, the larger the shorter they are (Rudnicki & Rice 1975,
doi:10.1016/0022-5096(75)90001-0, Schaeffer 1987, doi:10.1016/0022-0396(87)90038-6). A grid keeps the shortest, and the
numerical viscosity of the transfer damps them, the more steps there are to a second.
"""

import numpy as np

from snowmpm.materials import MuI
from snowmpm.study.atlas.entry import Entry
from snowmpm.study.problems.frictional_growth import DURATION, stirred_slab
from snowmpm.study.problems.granular_slab import exact_acceleration, gained, granular, pressed_slab
from snowmpm.study.problems.schemes import Scheme

SINE = 0.5
"""Sine of the friction angle of the slab."""
WRONG_SPEED, GROWN = 0.05, 1e-3
"""Limits of the entries below."""


def on_slope(cells, law, **scheme):
    """Solver of a granular slab on rough ground in the pressure of its weight, volume ratios and heights [m]."""
    return pressed_slab(law, Scheme(**{"transfer": "apic", **scheme}), cells)


def slab_speed(cells, **scheme):
    """Error of the acceleration of the upmost particles of a granular slab on rough ground, `cells` over its depth."""
    solver, volume_ratio, height = on_slope(max(1, round(cells)), granular(np.arcsin(SINE)), **scheme)
    surface = height > height.max() - 1e-9
    return gained(solver, volume_ratio, surface, np.array([1.0, 0.0])) / exact_acceleration(SINE) - 1.0


def mu_of_i(grains):
    """mu(I) with the friction at rest of the slab and grains of a diameter [m]."""
    soil = granular(np.arcsin(SINE)).model_dump(include={"density", "youngs_modulus", "poisson_ratio"})
    return MuI(**soil, static_friction=SINE, limit_friction=0.76, grain_diameter=grains, grain_density=2500.0)


def disturbance(cells, dilation=0.0, grains=None, **scheme):
    """Largest spread of the velocity along the slope, which should have none, over the speed of the surface, of a slab
    that is stirred; dilation [degrees]; grains [m]: diameter, with mu(I) as the law."""
    law = mu_of_i(grains) if grains else granular(np.arcsin(SINE)).model_copy(update={"dilation_angle": dilation})
    solver, states, rows = stirred_slab(law, round(cells), Scheme(**{"transfer": "apic", **scheme}))
    while solver.time < DURATION:
        for _ in range(50):
            solver.step(solver.stable_dt()[0])
        v = states.column("velocity")[rows]
        found = v.std(axis=1).max() / v[-1, :, 0].mean()
        if found > 2.0 * GROWN and solver.time > 0.05:
            break
    return found


ENTRIES = (
    Entry(
        name="shallow_flow", title="A flow of too few cells",
        scene="A granular slab on rough ground of 35 degrees, 8 cells along, periodic",
        seen="Its acceleration is wrong: what shears over a cell or two is as thick as the flow itself",
        cure='solver.transfer = "aflip" with flip_ratio = 0.99; a smaller solver.dx: so many cells over the depth',
        parameter="depth of the flow", unit="cells", values=(1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0), fails="below",
        settings={"apic": {"transfer": "apic"}, "aflip 0.99": {"transfer": "aflip", "flip_ratio": 0.99},
                  "flip 0.99": {"transfer": "flip", "flip_ratio": 0.99}, "pic": {"transfer": "pic"}},
        symptom="error of the acceleration", limit=WRONG_SPEED, measure=slab_speed, shown="apic", cured="aflip 0.99"),
    Entry(
        name="unstable_friction", title="Disturbances that grow in granular flow",
        scene="The same slab, 30 degrees of friction, stirred by a millionth of a metre a second, for 0.4 s",
        seen="What round-off or noise leaves grows by a factor e in 0.01 s on 40 cells until the plug above the"
             " shearing ground rocks, and the slab slides up to 37 % too fast. Not of the grid: with dilation_angle ="
             " friction_angle it dies out, in float64 it only begins later",
        cure='the law "mu_i" with grains of a thirteenth of the depth or so; fewer cells over the depth;'
             " solver.cfl = 0.1, whose steps damp it, up to 40 cells; a dilation_angle nearer to friction_angle",
        parameter="depth of the flow", unit="cells",
        values=(7.0, 10.0, 14.0, 20.0, 28.0, 40.0, 80.0),
        settings={"apic": {}, "apic, cfl 0.2": {"cfl": 0.2}, "apic, cfl 0.1": {"cfl": 0.1},
                  "cubic": {"kernel": "cubic"}, "aflip 0.99": {"transfer": "aflip", "flip_ratio": 0.99},
                  "flip 0.99": {"transfer": "flip", "flip_ratio": 0.99}, "dilation": {"dilation": 30.0},
                  "mu(I)": {"grains": 0.03}},
        symptom="spread of velocities along the slope", limit=GROWN, measure=disturbance,
        shown="apic", cured="apic, cfl 0.1", resolution=0.2),
)
