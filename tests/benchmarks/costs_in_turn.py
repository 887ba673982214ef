"""What choices of a scene cost: rows of `check_costs.py` that are measured here, steps with and without a choice in
turn, by the processor time of one thread."""

import time

import mpm_step
import numpy as np

from snowmpm import Simulation
from snowmpm.advice.calibration import Speed, measured_speed, speed_now
from snowmpm.measured import costs
from snowmpm.mpm.solver import MpmSolver
from snowmpm.scenes import load_scene
from snowmpm.scenes.schema import Scene
from snowmpm.schemes import BASES
from snowmpm.setup.build import build

FIELD, FASTEST_OF = 250, 50
"""Side [cells] of a sheet of many columns; steps of which the fastest counts."""
PLAIN_STEP, PAIRS, WARM_UP = "quadratic affine apic", 41, 6
LAYERS, TURNS = 10, 15
"""Of the mesh over a column; steps of which the median counts."""
MOST_STEPS = 400


def sph():
    """ns a particle of a step of SPH with the usual law, of a block in motion."""
    for dim in (2, 3):
        for precision in ("f32", "f64"):
            solver, times = Simulation(_sph_block(dim, precision)).solver, []
            for _ in range(12):
                start = time.process_time()
                solver.step(solver.stable_dt()[0])
                times.append(time.process_time() - start)
            yield "step", dim, precision, "sph", 1e9 * np.median(times[2:]) / solver.particles.count


def lengths():
    """ns a particle that smoothing lengths which follow the volume take more, as that of constant ones and the median
    ratio of steps taken in turn, of the same length."""
    names = "constant", "mean", "harmonic"
    for dim in (2, 3):
        solvers = [Simulation(_sph_block(dim, "f32", name)).solver for name in names]
        dt, taken = min(solver.stable_dt()[0] for solver in solvers), []
        for _ in range(3 + TURNS):
            taken.append([_seconds_of_step(solver, dt) for solver in solvers])
        for k, name in enumerate(names[1:], 1):
            ratio = np.median([row[k] / row[0] for row in taken[3:]])
            yield "more", dim, "f32", f"sph {name}", (ratio - 1.0) * costs.row("step", dim, "f32", "sph")


def _seconds_of_step(solver, dt):
    start = time.process_time()
    solver.step(dt)
    return time.process_time() - start


def _sph_block(dim, precision, lengths="constant"):
    snow = {"kind": costs.USUAL_LAW, "density": 250.0, "youngs_modulus": 3e6, "poisson_ratio": 0.3,
            "critical_slope": 0.5, "cohesion": 0.0, "hardening": 1.0, "p0": 1e5}
    size = [{2: 120.0, 3: 24.0}[dim]] * dim
    return Scene.model_validate({
        "name": "sph", "dimension": dim, "end_time": 1.0, "gravity": 0.0,
        "solver": {"method": "sph", "dx": 1.0, "precision": precision, "sph": {"lengths": lengths}},
        "domain": {"min": [-8.0] * dim, "max": [s + 8.0 for s in size]}, "materials": {"snow": snow},
        "bodies": [{"name": "block", "material": "snow", "velocity": [1.0] + [0.0] * (dim - 1),
                    "shape": {"kind": "box", "min": [0.0] * dim, "max": size}}]})


def interface():
    """ns that points of an interface add to a step, beside what they take as particles: to each particle of the scene,
    to each point and to the step, of the same particles with and without it in turn. And of a saw test, what follows
    its points: to each of them and to the step."""
    for dim, sides, most in ((2, (8, 2000), 16), (3, (4, 40), 4)):
        rows, more = [], []
        for side, points in ((sides[0], 1), (sides[1], 1), (sides[1], most)):
            count, n, ns = _with_and_without_points(dim, side, points)
            rows.append((count, n, 1.0))
            more.append(ns)
        for name, ns in zip(("particle", "point", "step"), np.linalg.solve(rows, more), strict=True):
            yield "mpm interface_layer", dim, "f32", name, max(0.0, ns)
        few, many = (_followed(dim, length) for length in ((4.0, 40.0) if dim == 2 else (2.0, 8.0)))
        point = max(0.0, (many[1] - few[1]) / (many[0] - few[0]))
        yield "mpm interface_layer", dim, "f32", "followed point", point
        yield "mpm interface_layer", dim, "f32", "followed step", max(0.0, few[1] - point * few[0])


class Slowness:
    """How many times as long as on the table's machine kernels and Python take while something is measured: the mean
    of samples, since a machine that others use is now slower, now faster."""

    def __init__(self):
        self._samples = []

    def sample(self):
        self._samples.append(speed_now().over(Speed(*costs.reference_speed())))

    def __call__(self):
        return np.mean(self._samples, axis=0)


def _with_and_without_points(dim, side, points):
    """-> (particles, points, median ns of a step that an interface adds, on the table's machine) of a slab of three
    cells at rest."""
    region = {"x": [8.0, 8.0 + side]} if dim == 2 else {"x": [8.0, 8.0 + side], "y": [8.0, 8.0 + side]}
    ground = {"kind": "profile", "points": [[0.0, 0.0], [side + 16.0, 0.0]]}
    snow = {"kind": "elastic", "density": 250.0, "youngs_modulus": 1e6, "poisson_ratio": 0.3}
    layers = {"weak_layer": (0.0, 0.2), "slab": (0.2, 3.2)}
    bodies = [{"name": name, "material": name, "shape": {"kind": "layer", "bottom": low, "top": high, "region": region}}
              for name, (low, high) in layers.items()]
    bodies[0]["interface"] = points
    model = build(Scene.model_validate({
        "name": "layer", "dimension": dim, "end_time": 1.0, "gravity": 0.0,
        "solver": {"dx": 1.0, "transfer": "aflip"}, "terrain": {**ground, "contact": "separate", "friction": 0.3},
        "domain": {"min": [0.0] * (dim - 1) + [-4.0], "max": [side + 16.0] * (dim - 1) + [8.0]},
        "materials": {name: snow for name in layers}, "bodies": bodies}))
    solvers = [model.solver(), MpmSolver.of(model.population, model.laws, model.scene.solver, **model._setting())]
    dt, taken, slowness = 0.5 * min(solver.stable_dt()[0] for solver in solvers), [], Slowness()
    for _ in range(WARM_UP + PAIRS):
        slowness.sample()
        taken.append([_seconds_of_step(solver, dt) for solver in solvers])
    more = np.median([row[0] - row[1] for row in taken[WARM_UP:]])
    points = solvers[0].workload.components["interface_layer"]["point"]
    return solvers[0].particles.count, points, 1e9 * more / slowness()[0]


def _followed(dim, length):
    """-> (points, mean ns that the record of a saw test and its saw take a step while it cuts, on the table's
    machine)."""
    simulation = Simulation(load_scene("pst_2d" if dim == 2 else "pst", {
        "solver.dx": 0.125, "saw_test.length": length, "saw_test.saw_start": 0.0, "initial.stress": "geostatic",
        "saw_test.weak_layer": {"material": "weak_layer", "thickness": 0.05, "interface": 8}}))
    spent = [0.0]

    def timed(call):
        def measured(*arguments):
            start = time.process_time()
            call(*arguments)
            spent[0] += time.process_time() - start
        return measured
    simulation.step()
    simulation.crack.watch = timed(simulation.crack.watch)
    saw = simulation.events[-1]
    saw.apply = timed(saw.apply)
    steps, slowness = 0, Slowness()
    while steps < MOST_STEPS and not saw.done:
        if steps % 10 == 0:
            slowness.sample()
        simulation.step()
        steps += 1
    points = simulation.solver.workload.components["interface_layer"]["point"]
    return points, 1e9 * spent[0] / steps / slowness()[1]


def columns():
    """ns a column, or a cell with snow, of a step of the depth-averaged method with Voellmy friction, of a sheet that
    slides down a plane; ns of a step of hardly any."""
    for scheme, name in (("columns", "depth"), ("volumes", "volumes")):
        for precision in ("f32", "f64"):
            many, few = (_least_step(side, precision, scheme) for side in (FIELD, 4))
            speed = measured_speed().over(Speed(*costs.reference_speed()))
            each = (many[1] - few[1]) / (many[0] - few[0])
            yield "step", 3, precision, name, each / speed[0]
            if precision == "f32":
                yield "call", 3, "f32", name, (few[1] - few[0] * each) / speed[1]


def _least_step(side, precision, scheme):
    """-> (columns or cells, ns of the fastest step) of a square of so many cells."""
    region = {"polygon": [[8.0, 8.0], [8.0 + side, 8.0], [8.0 + side, 8.0 + side], [8.0, 8.0 + side]]}
    scene = Scene.model_validate({
        "name": "columns", "dimension": 3, "end_time": 1.0, "solver": {"method": "depth", "dx": 1.0,
                                                                       "precision": precision,
                                                                       "depth": {"scheme": scheme}},
        "domain": {"min": [0.0, 0.0, -100.0 - side], "max": [side + 40.0, side + 16.0, 100.0]},
        "terrain": {"kind": "plane", "point": [0.0, 0.0, 0.0], "angle": 20.0,
                    "friction": {"law": "voellmy", "mu": 0.2, "xi": 1500.0}},
        "materials": {"snow": {"kind": "elastic", "density": 250.0, "youngs_modulus": 1e6, "poisson_ratio": 0.3}},
        "bodies": [{"name": "sheet", "material": "snow", "velocity": [5.0, 0.0, 0.0],
                    "shape": {"kind": "layer", "bottom": 0.0, "top": 1.0, "region": region}}]})
    solver, times = Simulation(scene).solver, []
    for _ in range(3 + FASTEST_OF):
        start = time.process_time()
        solver.step(solver.stable_dt()[0])
        times.append(time.process_time() - start)
    return solver.particles.count, 1e9 * min(times[3:])


def water():
    """ns that water in the pores adds to a step: a particle, or a column and layer, and a step. Of many and of few
    particles with and without it, step by step in turn."""
    for dim, sides in ((2, (10, 60)), (3, (4, 16))):
        for method in ("mpm", "implicit"):  # that of implicit steps is taken to be the same
            yield from _more_by_water(f"{method} pore_water", dim, "f64", [_soaked(dim, side) for side in sides])
        yield from _more_by_water("mpm two_velocities", dim, "f64", [_layered(dim, side) for side in sides])
        yield from _more_by_water("sph seepage", dim, "f64", [_seeping(dim, side) for side in sides])
    for precision in ("f32", "f64"):
        for scheme, made in (("one_phase", _slush), ("two_phase", _mixed)):
            pairs = [made(side, precision) for side in (8, 100)]
            yield from _more_by_water("depth flow_water", 3, precision, pairs, LAYERS, f"{scheme} layer",
                                      f"{scheme} step")


def _more_by_water(component, dim, precision, pairs, layers=1, of_particle="particle", of_step="step"):
    few, many = (_difference(pair) for pair in pairs)
    speed = measured_speed().over(Speed(*costs.reference_speed()))[0]
    a_particle = (many[1] - few[1]) / (many[0] - few[0]) / speed
    yield component, dim, precision, of_particle, a_particle / layers
    yield component, dim, precision, of_step, max(0.0, few[1] / speed - few[0] * a_particle)


def _difference(tables):
    """-> (particles, median over steps of the ns that the first scene takes more than the second)."""
    solvers, times = [Simulation(Scene.model_validate(table)).solver for table in tables], []
    for _ in range(3 + TURNS):
        taken = []
        for solver in solvers:
            start = time.process_time()
            solver.step(solver.stable_dt()[0])
            taken.append(time.process_time() - start)
        times.append(taken[0] - taken[1])
    return solvers[0].particles.count, 1e9 * float(np.median(times[3:]))


def _soaked(dim, side):
    """Tables of a block of so many cells a side with water and without."""
    dry = {"name": "soaked", "dimension": dim, "end_time": 1.0, "solver": {"dx": 1.0, "precision": "f64"},
           "domain": {"min": [0.0] * dim, "max": [float(side)] * (dim - 1) + [side + 4.0], "boundary": "slip"},
           "materials": {"snow": {"kind": "elastic", "density": 400.0, "youngs_modulus": 1e7, "poisson_ratio": 0.2}},
           "bodies": [{"name": "block", "material": "snow", "shape": {
               "kind": "box", "min": [0.0] * dim, "max": [float(side)] * dim}}]}
    return {**dry, "water": {"permeability": 1e-9}}, dry


def _layered(dim, side):
    """The same with particles of water beside those of snow, and twice as many dry particles."""
    _, dry = _soaked(dim, side)
    own = {**dry, "solver": {**dry["solver"], "transfer": "aflip"}}
    twice = {**own, "solver": {**own["solver"], "particles_per_cell": 2 ** (dim + 1)}}
    return {**own, "water": {"scheme": "v_w", "permeability": 1e-9}}, twice


def _seeping(dim, side):
    """The same for SPH, with particles of water at whose steps grains are at rest, and dry."""
    _, dry = _soaked(dim, side)
    dry = {**dry, "solver": {**dry["solver"], "method": "sph"}}
    return {**dry, "water": {"scheme": "seepage", "permeability": 1e-7}}, dry


def _slush(side, precision):
    """Tables of a sheet of so many cells a side on a plane, with water and without."""
    region = {"x": [8.0, 8.0 + side], "y": [8.0, 8.0 + side]}
    dry = {"name": "slush", "dimension": 3, "end_time": 1.0,
           "solver": {"method": "depth", "dx": 1.0, "precision": precision},
           "domain": {"min": [0.0, 0.0, -100.0 - side], "max": [side + 40.0, side + 16.0, 100.0]},
           "terrain": {"kind": "plane", "point": [0.0, 0.0, 0.0], "angle": 20.0, "friction": 0.2},
           "materials": {"snow": {"kind": "elastic", "density": 400.0, "youngs_modulus": 1e6, "poisson_ratio": 0.3}},
           "bodies": [{"name": "sheet", "material": "snow", "shape": {
               "kind": "layer", "bottom": 0.0, "top": 1.0, "region": region}}]}
    return {**dry, "water": {"scheme": "one_phase", "level": 0.5, "consolidation": 0.01, "layers": LAYERS}}, dry


def _mixed(side, precision):
    """The same with columns of water beside those of grains, and as many dry columns."""
    _, dry = _slush(side, precision)
    dry["materials"]["snow"]["density"] = 1500.0
    water = {"scheme": "two_phase", "grain_density": 2500.0, "consolidation": 0.01, "layers": LAYERS,
             "drag": {"law": "anderson", "terminal_velocity": 1e-3}}
    return {**dry, "water": water}, {**dry, "solver": {**dry["solver"], "particles_per_cell": 8}}


def pic():
    """ns a particle that PIC takes more than APIC: the median ratio of steps taken in turn, in blocks in motion, by the
    step of APIC in the table."""
    for dim in (2, 3):
        solvers = [mpm_step.make_solver(f"half{dim}", 60_000, "f32", transfer=name) for name in ("apic", "pic")]
        ratios = []
        for _ in range(3 + PAIRS):
            taken = []
            for solver in solvers:
                dt, start = solver.stable_dt()[0], time.process_time()
                solver.step(dt)
                taken.append(time.process_time() - start)
            ratios.append(taken[1] / taken[0])
        yield "more", dim, "f32", "pic", (np.median(ratios[3:]) - 1.0) * costs.row("step", dim, "f32", PLAIN_STEP)


def averaged_hats():
    """ns a particle that averaged hats take more than the splines, as that of the quadratic one with the same gradient
    and transfer and the median ratio of steps taken in turn."""
    for dim in (2, 3):
        names = ["quadratic", *(name for name, basis in BASES.items() if basis.box)]
        solvers = [mpm_step.make_solver(f"half{dim}", 60_000, "f32", transfer="flip", gradient="shape", kernel=name)
                   for name in names]
        taken = []
        for _ in range(3 + PAIRS):
            taken.append([])
            for solver in solvers:
                dt, start = solver.stable_dt()[0], time.process_time()
                solver.step(dt)
                taken[-1].append(time.process_time() - start)
        shape = costs.row("more", dim, "f32", "quadratic shape")
        whole = costs.row("step", dim, "f32", PLAIN_STEP) + costs.row("more", dim, "f32", "flip") + shape
        for k, name in enumerate(names[1:], 1):
            ratio = np.median([row[k] / row[0] for row in taken[3:]])
            yield "more", dim, "f32", f"{name} shape", shape + (ratio - 1.0) * whole
