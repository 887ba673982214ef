"""What components and frameworks cost: rows of `check_costs.py`, of steps with and without them in turn, or with few
elements and many, by the processor time of one thread."""

import time

import numpy as np
from costs_in_turn import Slowness
from scipy.optimize import nnls

from snowmpm import Simulation
from snowmpm.scenes.schema import Scene

PAIRS, SOLVED_PAIRS, WARM_UP = 25, 7, 3
"""Steps whose median counts, of waves and solved for."""
SIDES = {("mpm", 2): (10, 80), ("mpm", 3): (6, 24), ("implicit", 2): (8, 32), ("implicit", 3): (3, 5)}
"""Cells along a block with few points on its surface, and with many."""
SNOW = {"kind": "elastic", "density": 400.0, "youngs_modulus": 1e6, "poisson_ratio": 0.2}


def faces():
    """ns that a point of a load on a surface adds to a step, and all of them together: of blocks with a pressure on
    their whole surface and without it."""
    for (method, dim), sides in SIDES.items():
        few, many = (_more_by_faces(method, dim, side) for side in sides)
        point = max(0.0, (many[1] - few[1]) / (many[0] - few[0]))
        yield f"{method} face_loads", dim, "f32", "point", point
        yield f"{method} face_loads", dim, "f32", "step", max(0.0, few[1] - point * few[0])


def _more_by_faces(method, dim, side):
    """-> (points, median over steps of the ns that they add, on the table's machine)."""
    loads = [{"kind": "follower_pressure", "name": "air", "body": "block", "value": 10.0}]
    solver, more = _more_by(_block(method, dim, side), {"forces": loads})
    return solver.adapters["face_loads"].faces.count, more


def _block(method, dim, side):
    """Tables of a block of so many cells along a side."""
    solver = {"mpm": {"dx": 1.0}, "implicit": {"method": "implicit", "dx": 1.0, "implicit": {
        "time": "newmark", "dt": 1e-2}}}[method]
    return {"name": "loaded", "dimension": dim, "end_time": 1.0, "solver": solver, "materials": {"snow": SNOW},
             "domain": {"min": [-4.0] * (dim - 1) + [0.0], "max": [side + 4.0] * dim, "boundary": {"z_min": "stick"}},
             "bodies": [{"name": "block", "material": "snow", "shape": {
                 "kind": "box", "min": [0.0] * dim, "max": [float(side)] * dim}}]}


def _more_by(plain, component, looks=0, share=0.5):
    """-> (solver with a component, median over steps of the ns that it adds to a step, on the table's machine). looks:
    steps to warm up and to take the mean of, for a component that does not act in each; share: of the longest step."""
    both = {**plain, **component}, plain
    solvers, taken, slowness = [Simulation(Scene.model_validate(one)).solver for one in both], [], Slowness()
    dt = share * min(solver.stable_dt()[0] for solver in solvers)
    warm_up = looks or WARM_UP
    for _ in range(warm_up + (looks or (SOLVED_PAIRS if "implicit" in plain["solver"] else PAIRS))):
        slowness.sample()
        taken.append([_seconds_of_step(solver, dt) for solver in solvers])
    more = (np.mean if looks else np.median)([row[0] - row[1] for row in taken[warm_up:]])
    return solvers[0], 1e9 * more / slowness()[1]


def _seconds_of_step(solver, dt):
    start = time.process_time()
    solver.step(dt)
    return time.process_time() - start


def cells():
    """ns that one change of volume a cell adds to a step, a particle: of blocks with it and without it."""
    for (method, dim), (_, side) in SIDES.items():
        if method == "mpm":
            solver, more = _more_by(_block(method, dim, side), {"solver": {"dx": 1.0, "f_bar": True}})
            yield f"{method} f_bar", dim, "f32", "particle", max(0.0, more / solver.particles.count)


def panels():
    """ns that a node beside an obstacle with panels adds to a step, and all of them together: of blocks beside a wall
    with panels and without them."""
    for dim in (2, 3):
        found = []
        for side in SIDES["mpm", dim]:
            wall = {"name": "wall", "shape": {"kind": "box", "min": [float(side), *[-1.0] * (dim - 1)],
                                              "max": [side + 3.0] + [side + 1.0] * (dim - 1)}}
            plain = {**_block("mpm", dim, side), "obstacles": [wall]}
            face = {"size": 2.0, "direction": [1.0] + [0.0] * (dim - 1), "interval": 10.0}
            solver, more = _more_by(plain, {"obstacles": [{**wall, "panels": face}]})
            found.append((solver.adapters["pressure_panels"].work()["node"], more))
        (few, short), (many, long) = found
        node = max(0.0, (long - short) / (many - few))
        yield "mpm pressure_panels", dim, "f32", "node", node
        yield "mpm pressure_panels", dim, "f32", "step", max(0.0, short - node * few)


def covers():
    """ns that snow cover which is laid ahead adds to a step, a particle and in all: of blocks beside such snow and
    beside a body like others. In each step the rim is held; looks at the cover are a share of that."""
    for dim in (2, 3):
        found = []
        for side in SIDES["mpm", dim]:
            plain = _block("mpm", dim, side)
            far = {"name": "cover", "material": "snow", "shape": {
                "kind": "box", "min": [side + 2.0] + [0.0] * (dim - 1), "max": [side + 12.0] + [4.0] * (dim - 1)}}
            plain["domain"]["max"][0] = side + 16.0
            plain["bodies"] = [*plain["bodies"], far]
            solver, more = _more_by(plain, {"bodies": [plain["bodies"][0], {**far, "laid_ahead": 9.0}]})
            found.append((solver.particles.count, more))
        (few, short), (many, long) = found
        particle = max(0.0, (long - short) / (many - few))
        yield "mpm erodible_snow", dim, "f32", "particle", particle
        yield "mpm erodible_snow", dim, "f32", "step", max(0.0, short - particle * few)


def beds():
    """ns that thin snow cover which is taken up adds to a step, a particle and in all: of blocks that slide over such
    snow and over bare ground. Looks at it and particles that join are a share of the steps: their mean counts."""
    for dim in (2, 3):
        found = []
        for side in SIDES["mpm", dim]:
            plain = _block("mpm", dim, side)
            plain["bodies"][0]["velocity"] = [10.0] + [0.0] * (dim - 1)
            plain["domain"] = {"min": [-4.0] * dim, "max": [side + 24.0] * dim}
            ground = {"kind": "plane", "angle": 0.0, "contact": "separate", "friction": 0.3}
            cover = {"law": "erosion_energy", "energy": 2000.0, "thickness": 1.0}
            covered = {"terrain": {**ground, "entrainment": cover}}
            solver, more = _more_by({**plain, "terrain": ground}, covered, looks=60)
            found.append((solver.particles.count, more))
        (few, short), (many, long) = found
        particle = max(0.0, (long - short) / (many - few))
        yield "mpm entrainment", dim, "f32", "particle", particle
        yield "mpm entrainment", dim, "f32", "step", max(0.0, short - particle * few)


def clouds():
    """ns that a powder layer adds to a step, a cell of its live tiles and in all: of slabs that slide down a slope with
    it and without it, in steps as long as those of runs."""
    found = []
    for side in (30.0, 160.0):
        plain = {"name": "dust", "dimension": 3, "end_time": 60.0, "solver": {"method": "depth", "dx": 2.0},
                 "domain": {"min": [0.0, 0.0, -400.0], "max": [side + 240.0, side + 80.0, 20.0]},
                 "materials": {"snow": SNOW},
                 "terrain": {"kind": "plane", "angle": 35.0, "friction": {"law": "voellmy", "mu": 0.2, "xi": 2000.0}},
                 "bodies": [{"name": "slab", "material": "snow", "velocity": [16.0, 0.0, -11.2], "shape": {
                     "kind": "layer", "top": 1.0, "region": {"x": [20.0, side + 20.0], "y": [40.0, side + 40.0]}}}]}
        solver, more = _more_by(plain, {"powder_layer": {}}, looks=60, share=1.0)
        found.append((solver.adapters["powder_layer"].work()["cell"], more))
    (few, short), (many, long) = found
    cell = max(0.0, (long - short) / (many - few))
    yield "depth powder_layer", 3, "f32", "cell", cell
    yield "depth powder_layer", 3, "f32", "step", max(0.0, short - cell * few)


def frameworks():
    """ns of a step that an element of a framework takes, beside its contact with snow as an obstacle that moves, each
    of its substeps, and each unknown where it goes to rest in every step: of fences with few elements and with many,
    soft and stiff ones, by least squares. Motion and obstacles are the same in both dimensions."""
    rows, spent = [], []
    for elements in (2, 8):
        for keys in ({"youngs_modulus": 1e7}, {"youngs_modulus": 1e11},
                     {"youngs_modulus": 1e9, "response": "static", "coupling": "one_way"}):
            counts, ns = _step_of_fence(elements, keys)
            rows.append(counts)
            spent.append(ns)
    factors = nnls(np.array(rows) / np.array(spent)[:, None], np.ones(len(spent)))[0]
    for dim in (2, 3):
        for name, ns in zip(("element", "substep", "unknown"), factors, strict=False):
            for method in ("mpm", "sph"):
                yield f"{method} structures", dim, "f32", name, ns


def _step_of_fence(elements, keys):
    """-> (elements, their substeps, unknowns, 1), median ns of a step but for transfers, grid and contact of a fence
    beside a block of snow in 3-D, on the table's machine."""
    members = [{"ends": list(ends), "segments": elements} for ends in (("a", "b"), ("b", "c"), ("c", "d"))]
    scene = Scene.model_validate({
        "name": "fence", "dimension": 3, "end_time": 1.0, "solver": {"dx": 0.2}, "materials": {"snow": SNOW},
        "domain": {"min": [-2.0, -2.0, 0.0], "max": [4.0, 4.0, 4.0], "boundary": {"z_min": "stick"}},
        "bodies": [{"name": "block", "material": "snow",
                    "shape": {"kind": "box", "min": [-0.8, 0.0, 0.0], "max": [-0.2, 2.0, 0.8]}}],
        "structures": [{"name": "fence", "width": 0.2, "density": 4000.0, **keys,
                        "joints": {"a": [0.0, 0.0, 0.0], "b": [0.0, 0.0, 1.8], "c": [0.0, 2.0, 1.8],
                                   "d": [0.0, 2.0, 0.0]},
                        "feet": {"a": "fixed", "d": "fixed"}, "members": members}]})
    solver = Simulation(scene).solver
    other, slowness, taken = [0.0], Slowness(), []

    def timed(call):
        def measured(*arguments):
            start = time.process_time()
            call(*arguments)
            other[0] += time.process_time() - start
        return measured
    for name in ("particles_to_grid", "update_grid", "grid_to_particles", "sort"):
        setattr(solver, name, timed(getattr(solver, name)))
    for _ in range(WARM_UP + PAIRS):
        slowness.sample()
        other[0] = 0.0
        whole = _seconds_of_step(solver, solver.stable_dt()[0])
        taken.append(whole - other[0])
    work = solver.workload
    return (work.elements, work.substeps, work.unknowns, 1.0), 1e9 * np.median(taken[WARM_UP:]) / slowness()[1]


