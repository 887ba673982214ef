"""The problems of the studies, by name."""

import numpy as np

from snowmpm.study.problem import FOR_THE_STEP, MAIN, Problem
from snowmpm.study.problems import (
    anticrack,
    bar_vibration,
    cantilever,
    column_collapse,
    elastic_saw_test,
    energy_line,
    generalised_vortex,
    granular_slab,
    periodic_waves,
    piston,
)
from snowmpm.study.problems import self_weight_column as column

SINE = 0.5
"""Sine of the friction angle of the granular slab."""


def _waves(scheme, cells, per_axis):
    courant = scheme.courant(periodic_waves.LAW, 2)
    return periodic_waves.wave_errors(scheme, cells, per_axis=per_axis, courant=courant).displacement


def _vortex(scheme, cells, per_axis):
    courant = scheme.courant(generalised_vortex.LAW, 2)
    return generalised_vortex.vortex_errors(scheme, cells, per_axis=per_axis, courant=courant).displacement


def _bar(scheme, cells, per_axis, dim=2, **options):
    courant = scheme.courant(bar_vibration.LAW, dim)
    return bar_vibration.shape_error(scheme, cells, per_axis=per_axis, dim=dim, courant=courant, **options)


def _column(scheme, cells, per_axis, offset=0.0, wall="side"):
    angle = 0.5 * np.pi if wall == "obstacle" else None
    return column.column_errors(column.SOFT, 10.0, scheme, offset, angle, cells, per_axis)[0]


def _cantilever(scheme, cells, per_axis):
    down = -cantilever.hang(cantilever.SMALL_LOAD, cantilever.THICKNESS, scheme, cells, per_axis)[1]
    return down / cantilever.small_deflection() - 1.0


def _slab(scheme, cells, per_axis, offset=0.0):
    found = granular_slab.acceleration(np.arcsin(SINE), scheme, cells, offset, per_axis=per_axis)
    return found / granular_slab.exact_acceleration(SINE) - 1.0


def _piston(scheme, cells, per_axis, return_map="implicit"):
    law, exact = piston.FIRM.model_copy(update={"return_map": return_map}), piston.FRONTS["firm", 4.3]
    found = piston.drive(law, scheme, 4.3, exact, 1.5, piston.WAY / cells, per_axis)[:3]
    return np.sqrt(np.mean((np.array(found) / exact - 1.0) ** 2))


def _fresh(scheme, cells, per_axis):
    exact = piston.FRONTS["fresh", 4.3]
    found = piston.drive(piston.FRESH, scheme, 4.3, exact, 4.5, piston.WAY / cells, per_axis)[:3]
    return np.sqrt(np.mean((np.array(found) / exact - 1.0) ** 2))


def _collapse(scheme, cells, per_axis):
    return column_collapse.run_out(scheme, cells, per_axis) / column_collapse.RUN_OUT - 1.0


CATALOGUE = {problem.name: problem for problem in (
    Problem("waves", "elastic", "standing waves (M6)", "displacement, root mean square over the amplitude",
            "the period", periodic_waves.LAW, _waves, 2.0, (8, 16, 32, 64), (8, 16, 32), 32),
    Problem("vortex", "elastic", "generalised vortex (M7)", "displacement, root mean square over the amplitude",
            "a metre", generalised_vortex.LAW, _vortex, 2.0, (8, 16, 32, 64), (8, 16, 32), 16),
    Problem("bar", "elastic", "vibrating bar (M4)", "velocity after 1.9 periods, root mean square over that of the"
            " start", "its length", bar_vibration.LAW, _bar, 2.0, (12, 25, 50, 100), (12, 25), 25,
            frozenset({"offset", "dim"}), sph=True),
    Problem("column", "elastic", "column under its weight (M5)", "largest error of a height over the settlement",
            "its height", column.SOFT, _column, None, (8, 16, 32, 64), (8, 16), 32, frozenset({"offset", "wall"}),
            sph=True),
    Problem("cantilever", "elastic", "hanging cantilever (M11)", "deflection of its end", "its thickness",
            cantilever.law(), _cantilever, None, (2, 3, 4), (), 3, choices=MAIN),
    Problem("slab", "granular", "granular slab on a slope (M15)", "acceleration of its surface", "its depth",
            granular_slab.granular(np.arcsin(SINE)), _slab, None, (5, 10, 20, 40), (5, 10, 20), 10,
            frozenset({"offset"}), sph=True),
    Problem("piston", "impact", "compaction wave (M10)", "speed, stress and density of the front, root mean square",
            "half a metre of its way", piston.FIRM, _piston, None, (25, 50, 100, 200), (25, 50), 50,
            frozenset({"return_map"}), sph=True),
    Problem("fresh", "impact", "wave in fresh snow (M10)", "speed, stress and density of the front, root mean square",
            "half a metre of its way", piston.FRESH, _fresh, None, (25,), (), 25, choices=FOR_THE_STEP),
    Problem("collapse", "granular", "column collapse (G1)", "run-out, against the law of the experiments",
            "its height", column_collapse.SAND, _collapse, None, (5, 10), (), 10, sph=True,
            choices=(*FOR_THE_STEP, "SPH")),
    Problem("saw_test", "elastic", "elastic saw test (S1)", "energy release rate and deflection, root mean square",
            "the height of the slab", elastic_saw_test.SLAB, elastic_saw_test.flat_error, None, (10, 20, 40), (),
            20, choices=MAIN),
    Problem("anticrack", "damage", "crack in a weak layer (S2, S3)",
            "settlement and work of collapse, root mean square",
            "the height of the slab", anticrack.SLAB, anticrack.collapse_error, None, (10, 14, 20), (), 20,
            choices=FOR_THE_STEP),
    Problem("energy_line", "elastic", "thin strip to its stop (M19)", "way until it stops", "its thickness",
            energy_line.SOFT, energy_line.run_out_error, None, (1, 2), (), 2, choices=FOR_THE_STEP),
)}
