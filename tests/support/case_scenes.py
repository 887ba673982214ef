"""Verification cases as scenes that a user can write, with the usual settings: the error of each.

A function a case; each returns {quantity: error}, relative to the reference. What is read is what a run's history and
particles hold.
"""

import numpy as np

from snowmpm.running.simulation import Simulation
from snowmpm.scenes import Scene
from snowmpm.study.problems.energy_line import DIP, LONG, MU, RADIUS, THICK, exact_way
from snowmpm.study.problems.piston import FIRM, FRESH, FRONTS

G = 9.81


def simulation(dx, materials, bodies, end=100.0, **tables):
    """`Simulation` of a scene in two dimensions with nothing chosen in [solver] but dx."""
    return Simulation(Scene.model_validate({
        "name": "case", "dimension": 2, "end_time": end, "solver": {"dx": dx}, "materials": {"m": materials},
        "bodies": [{"name": f"body{i}", "material": "m", **body} for i, body in enumerate(bodies)], **tables}))


def elastic(density, youngs_modulus, poisson_ratio):
    return {"kind": "elastic", "density": density, "youngs_modulus": youngs_modulus, "poisson_ratio": poisson_ratio}


def box(low, high):
    return {"kind": "box", "min": list(low), "max": list(high)}


def at(sim, times, read):
    """What `read(sim)` gives at some times (n, ...)."""
    found = []
    for time in times:
        while sim.time < time - 1e-12:
            sim.step(until=time)
        found.append(read(sim))
    return np.array(found)


def mean(sim, name):
    fields = sim.particles
    return fields["mass"] @ fields[name] / fields["mass"].sum()


def crossings(time, values):
    """Times at which values change their sign, by interpolation."""
    n = np.flatnonzero(values[:-1] * values[1:] < 0.0)
    return time[n] - values[n] * (time[n + 1] - time[n]) / (values[n + 1] - values[n])


def bar_vibration(cells=50):
    """M4: a bar in its first mode, set going by a body force of 0.05 s; its period of 10 s."""
    length, short = 25.0, 0.05
    dx = length / cells
    sim = simulation(dx, elastic(1.0, 100.0, 0.0), [{"shape": box([0.0, 0.0], [length, 3.0 * dx])}], gravity=0.0,
                     domain={"min": [0.0, 0.0], "max": [2.0 * length, 3.0 * dx],
                             "boundary": {"x_min": "stick", "z_min": "slip", "z_max": "slip"}},
                     forces=[{"kind": "acceleration", "stop": short,
                              "value": [f"{0.1 / short}*sin(pi*x/{2.0 * length})", 0.0]}])
    time = np.arange(0.05, 19.0, 0.05)
    found = crossings(time, at(sim, time, lambda sim: mean(sim, "velocity")[0]))
    return {"period": 2.0 * np.diff(found).mean() / 10.0 - 1.0}


def bar_impact(speed=1.0, exact=31962.1):
    """M9: a bar against a wall; the force by the momentum that it loses, in the first passage of the wave."""
    wave = np.sqrt(3e6 * 0.7 / (1.3 * 0.4) / 250.0)
    bar = {"shape": box([0.0, 0.0], [1.0, 0.04]), "velocity": [-speed, 0.0]}
    sim = simulation(0.01, elastic(250.0, 3e6, 0.3), [bar], gravity=0.0,
                     domain={"min": [0.0, 0.0], "max": [2.0, 0.04],
                             "boundary": {"x_min": "separate", "z_min": "slip", "z_max": "slip"}})
    time = np.linspace(0.4, 1.6, 40) / wave
    lost = at(sim, time, lambda sim: sim.audit()["momentum_x"])
    return {"stress on the wall": np.polyfit(time, lost, 1)[0] / 0.04 / exact - 1.0}


def plastic_front(snow, length, speed=4.3):
    """M10: a wall drives into snow: speed of the front, pressure on the wall, density behind the front."""
    law = {"firm": FIRM, "fresh": FRESH}[snow]
    front, pressure, density = FRONTS[snow, speed]
    sim = simulation(0.01, law.model_dump(exclude_none=True), [{"shape": box([0.0, 0.0], [length, 0.04])}], gravity=0.0,
                     domain={"min": [-0.1, 0.0], "max": [1.5 * length, 0.04],
                             "boundary": {"z_min": "slip", "z_max": "slip"}},
                     obstacles=[{"name": "wall", "friction": 0.0, "contact": "slip",
                                 "shape": box([-0.2, -0.2], [0.0, 0.3]), "motion": {"velocity": [speed, 0.0]}}])
    half = 0.5 * (1.0 + law.density / density)
    start = sim.particles["position"][np.argsort(sim.particles["id"]), 0]
    time = np.linspace(0.0, 0.5 / front, 60)[1:]
    found = at(sim, time, lambda sim: [(sim.particles["J"] < half).mean() * length, -sim.obstacle_totals[0, 0] / 0.04])
    gone = found[:, 0] > 0.15
    fields = sim.particles
    behind = (start[fields["id"]] > 0.05) & (start[fields["id"]] < 0.4)
    slopes = [np.polyfit(time[gone], found[gone, k], 1)[0] for k in (0, 1)]
    return {"front": slopes[0] / front - 1.0, "pressure": slopes[1] / pressure - 1.0,
            "density": (law.density / fields["J"][behind]).mean() / density - 1.0}


def block_on_incline(angle=24.0, friction=15.0):
    """M12: acceleration of a block that slides down a plane."""
    a, mu = np.radians(angle), np.tan(np.radians(friction))
    sim = simulation(0.01, elastic(1000.0, 1e6, 0.3), [{"shape": {
        "kind": "layer", "bottom": 0.0, "top": 0.05, "region": {"x": [0.0, float(0.1 * np.cos(a))]}}}],
        domain={"min": [-0.5, -1.5], "max": [1.5, 0.6]}, initial={"stress": "geostatic"},
        terrain={"kind": "plane", "angle": angle, "friction": float(mu)})
    time, along = np.linspace(0.04, 0.4, 73), np.array([np.cos(a), -np.sin(a)])
    found = np.polyfit(time, at(sim, time, lambda sim: mean(sim, "velocity") @ along), 1)[0]
    return {"acceleration": found / (G * (np.sin(a) - mu * np.cos(a))) - 1.0}


def disc_on_incline(friction, dx=0.025):
    """M13: acceleration of a disc of a radius of 0.5 m that rolls (friction 0.5) or slips (0.1) down 30 degrees."""
    a, radius = np.radians(30.0), 0.5
    sim = simulation(dx, elastic(1000.0, 5e6, 0.3), [{"shape": {
        "kind": "sphere", "radius": radius, "centre": [float(radius * np.sin(a)), float(radius * np.cos(a))]}}],
        domain={"min": [-2.0, -6.0], "max": [6.0, 2.0]}, terrain={"kind": "plane", "angle": 30.0, "friction": friction})
    time, along = np.linspace(0.1, 1.0, 46), np.array([np.cos(a), -np.sin(a)])
    found = np.polyfit(time, at(sim, time, lambda sim: mean(sim, "velocity") @ along), 1)[0]
    rolls = friction > np.tan(a) / 3.0
    return {"acceleration": found / (2.0 / 3.0 * G * np.sin(a) if rolls else
                                     G * (np.sin(a) - friction * np.cos(a))) - 1.0}


def granular_slope(sine=0.5):
    """M15: acceleration of the top of a layer of sand whose friction is below its slope of 35 degrees."""
    a = np.radians(35.0)
    sim = simulation(0.02, {"kind": "drucker_prager", "density": 1500.0, "youngs_modulus": 1e6, "poisson_ratio": 0.3,
                            "cone": "plane_strain", "friction_angle": float(np.degrees(np.arcsin(sine)))},
                     [{"shape": box([0.0, 0.0], [0.16, 0.4])}], gravity=[float(G * np.sin(a)), float(-G * np.cos(a))],
                     initial={"stress": "geostatic"}, domain={"min": [0.0, 0.0], "max": [0.16, 0.8], "boundary": {
                         "x_min": "periodic", "x_max": "periodic", "z_min": "stick"}})
    fields = sim.particles
    top = np.zeros(sim.n_particles, bool)
    top[fields["id"]] = fields["position"][:, 1] > 0.36
    time = np.linspace(0.16, 0.4, 25)
    found = at(sim, time, lambda sim: sim.particles["velocity"][top[sim.particles["id"]], 0].mean())
    return {"acceleration": np.polyfit(time, found, 1)[0] / (G * (np.sin(a) - sine * np.cos(a))) - 1.0}


def colliding_discs(dx=0.025):
    """M16: kinetic energy that the centres of two elastic discs keep, 0.785 of it."""
    discs = [{"velocity": [v, v], "shape": {"kind": "sphere", "centre": [c, c], "radius": 0.2}}
             for c, v in ((0.2, 0.1), (0.8, -0.1))]
    sim = simulation(dx, elastic(1000.0, 1000.0, 0.3), discs, gravity=0.0,
                     domain={"min": [-0.6, -0.6], "max": [1.6, 1.6]})
    at(sim, [2.8], lambda sim: None)
    fields = sim.particles
    speed = fields["velocity"][fields["body"] == 0].mean(axis=0) @ np.full(2, np.sqrt(0.5))
    return {"energy of the centres": (speed / (0.1 * np.sqrt(2.0))) ** 2 / 0.785 - 1.0}


def energy_line(cells=4):
    """M19: way of a slab down a slope with a bend of constant radius, and out on the flat."""
    dx = THICK / cells
    foot = np.array([-RADIUS * np.sin(DIP), RADIUS * (1.0 - np.cos(DIP))])
    down, normal = np.array([np.cos(DIP), -np.sin(DIP)]), np.array([np.sin(DIP), np.cos(DIP)])
    rear = foot - 10.0 * down
    corners = [rear, rear + LONG * down, rear + LONG * down + THICK * normal, rear + THICK * normal]
    points = [[-20.0, float(foot[1] + (foot[0] + 20.0) * np.tan(DIP))], [float(-RADIUS * np.tan(0.5 * DIP)), 0.0],
              [30.0, 0.0]]
    sim = simulation(dx, elastic(300.0, 2e5, 0.0), [{"shape": {
        "kind": "polygon", "points": [[float(value) for value in corner] for corner in corners]}}],
        domain={"min": [-20.0, -2.0], "max": [30.0, 12.0]},
        terrain={"kind": "profile", "points": points, "fillet": RADIUS, "friction": MU})

    def way(place):
        turned = DIP - np.arctan2(-place[:, 0], RADIUS - place[:, 1])
        before = (place - foot) @ down
        return np.where(before < 0.0, before, np.where(place[:, 0] > 0.0, RADIUS * DIP + place[:, 0], RADIUS * turned))

    begin = way(sim.particles["position"]).mean()
    time = 1.0
    while time < 14.0 and (time < 1.5 or sim.max_speed > 0.02):
        time += 0.5
        at(sim, [time], lambda sim: None)
    return {"way": (way(sim.particles["position"]).mean() - begin) / (exact_way(begin, 0.5 * THICK) - begin) - 1.0}
