"""Specimens of rock-like material that crack between rigid rollers or platens: a notched beam, a half disc, a ring.

Plane strain, without weight; E = 1 MPa, nu = 0.2, rho = 1000 kg/m3, f_t = 1 kPa, G_f = 0.08 J/m2, so that the length
E G_f / f_t^2 is 80 mm, as of rocks, while waves are slow enough for explicit steps. Cells must be below 66 mm. Rollers
and platens are obstacles that let go; one of them, the press, comes down ever faster: half of its way
is made in the last quarter of the time. A specimen has a whole number of cells, the middle one with its centre on the
axis of the load, and so have notches: a crack along the axis lies in one column of cells.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from snowmpm.materials import CohesiveCrack
from snowmpm.running.simulation import Simulation
from snowmpm.scenes.schema import Scene
from snowmpm.solids.motion import RigidMotion
from snowmpm.study.problems.particle_states import ParticleStates
from tests.support.driven import loads

ROCK = CohesiveCrack(density=1e3, youngs_modulus=1e6, poisson_ratio=0.2, strength=1e3, fracture_energy=0.08,
                     friction_angle=30.0)  # fmt: skip
MARGIN = 12
"""Cells around a specimen, with the rollers."""


@dataclass(frozen=True)
class Loaded:
    """A test in time: at each reading its time [s], way of the press [m], its force and that of the other obstacles
    since the reading before, upwards, per width [N/m], displacements of the gauges (readings, gauges) [m], damage of
    all particles (readings, n), and their kinetic energy [J/m]; at the start x (n, 2) [m]; at the end
    normal (n, 2), the diagonal of n n of their cracks, and work [J/m] of the press. dx [m]."""

    dx: float
    time: np.ndarray
    way: np.ndarray
    force: np.ndarray
    reaction: np.ndarray
    gauges: np.ndarray
    damage: np.ndarray
    kinetic: np.ndarray
    x: np.ndarray
    normal: np.ndarray
    work: float


def scene(name, dx, shapes, half, height, rests, press, way, seconds, friction=0.0):
    """`Scene` of a specimen from -half to half and 0 to height [m]; rests, press: shapes of obstacles; the press comes
    down by `way` [m] in `seconds`."""
    far = MARGIN * dx
    still = [{"name": f"rest_{i}", "friction": friction, "shape": rest} for i, rest in enumerate(rests)]
    moving = {"name": "press", "friction": friction, "shape": press,
              "motion": {"velocity": [0.0, -2.0 * way / seconds], "ramp": seconds}}
    return Scene.model_validate({
        "name": name, "dimension": 2, "end_time": seconds, "gravity": 0.0, "output": {"interval": seconds / 50},
        "solver": {"dx": dx, "precision": "f64", "transfer": "aflip", "flip_ratio": 0.99, "f_bar": "whole"},
        "domain": {"min": [-half - far, -far], "max": [half + far, height + far]},
        "materials": {"rock": ROCK.model_dump(exclude_none=True)},
        "bodies": [{"name": f"part_{i}", "material": "rock", "shape": shape} for i, shape in enumerate(shapes)],
        "obstacles": [*still, moving]})  # fmt: skip


def load(tested, gauges=(), readings=200):
    """`Loaded` of a scene; gauges: functions of positions (n, 2) [m] -> which particles (n,) a gauge follows."""
    simulation = Simulation(tested)
    states, press = ParticleStates(simulation.solver), len(tested.obstacles) - 1
    motion = RigidMotion.of(tested.obstacles[press].motion, np.zeros(2))
    followed = [gauge(states.reference) for gauge in gauges]
    times = tested.end_time * np.linspace(0.0, 1.0, readings + 1)[1:]
    rows, damage, before = [], [], np.zeros(press)
    for on_press in loads(simulation, press, times):
        moved = states.positions() - states.reference
        given = np.array(simulation.solver.obstacle_totals[:press, 1], float)
        kinetic = 0.5 * (states.mass[:, None] * states.column("velocity") ** 2).sum()
        rows.append((simulation.time, -motion.pose(simulation.time).centre[1], on_press[1], kinetic,
                     *(moved[one, 1].mean() for one in followed), *(given - before)))
        before = given
        damage.append(states.column("state")[:, 0].astype(np.float32))
    table = np.array(rows)
    reaction = table[:, 4 + len(gauges):] / np.diff(table[:, 0], prepend=0.0)[:, None]
    state = states.column("state")
    return Loaded(tested.solver.dx, *table[:, :3].T, reaction, table[:, 4 : 4 + len(gauges)], np.array(damage),
                  table[:, 3], states.reference, state[:, [2, 3]],
                  -float(simulation.solver.obstacle_totals[press, -1]))  # fmt: skip


# ---- beam ------------------------------------------------------------------------------------------------------

DEPTH, NOTCH, ARM, ROLLER = 0.048, 0.012, 0.06, 0.007
"""Of beam and notch, half the span, radius of the rollers [m]."""


def polygon(points):
    """The shape of corners (n, 2) [m]."""
    return {"kind": "polygon", "points": np.round(points, 9).tolist()}


def beam_scene(dx, way=0.9e-3, seconds=0.7):
    """A beam with a notch of one cell below its middle, on two rollers, under a third."""
    half = dx * (round(0.072 / dx) + 0.5)
    w = 0.5 * dx
    outline = [[-half, 0.0], [-w, 0.0], [-w, NOTCH], [w, NOTCH], [w, 0.0], [half, 0.0], [half, DEPTH], [-half, DEPTH]]
    rests = [{"kind": "sphere", "centre": [side * ARM, -ROLLER], "radius": ROLLER} for side in (-1, 1)]
    press = {"kind": "sphere", "centre": [0.0, DEPTH + ROLLER], "radius": ROLLER}
    return scene("notched_beam", dx, [polygon(outline)], half, DEPTH, rests, press, way, seconds)


def at_half_depth(middle, width):
    """Gauge: particles within `width` of `middle` along the beam, none beside its crack, 6 mm around half its depth."""
    def chosen(x):
        along = np.abs(x[:, 0] - middle)
        return (along < width) & (np.abs(x[:, 0]) > 0.003) & (np.abs(x[:, 1] - DEPTH / 2) < 0.006)

    return chosen


@cache
def bent(dx, **options):
    """`Loaded` notched beam; gauges: middle, left and right support."""
    gauges = at_half_depth(0.0, 0.012), at_half_depth(-ARM, 0.006), at_half_depth(ARM, 0.006)
    return load(beam_scene(dx, **options), gauges)


def deflection(beam):
    """Of the middle against the supports, within the beam, at the middle of the readings' intervals [m]."""
    sag = beam.gauges[:, 1:].mean(axis=1) - beam.gauges[:, 0]
    return 0.5 * (sag + np.concatenate([[0.0], sag[:-1]]))


def bonds_lost(beam):
    """Energy of the cohesion that cracks have lost by the end, per width [J/m]: over a crack of damage ω, of linear
    cohesion, G_f (2 ω - ω^2) per area; a particle has a quarter of its cell's area."""
    damage = beam.damage[-1].astype(float)
    return 0.25 * beam.dx * ROCK.fracture_energy * (2.0 * damage - damage**2).sum()


# ---- half disc and ring ----------------------------------------------------------------------------------------

RADIUS, CELLS = 0.05, 51
"""Of half disc and ring [m]; cells over the diameter."""
CUT, HALF_SPAN, SMALL_ROLLER, GRIP = 0.02, 0.03, 0.006, 0.5
"""Length of the half disc's notch, half the span of its rollers, their radius [m]; friction of rollers and platens,
without which the specimen rolls away."""


def arc(radius, begin, end, centre=(0.0, 0.0)):
    """Points of a circle between two angles [degrees]."""
    angles = np.radians(np.linspace(begin, end, max(8, round(abs(end - begin)))))
    return np.stack([centre[0] + radius * np.cos(angles), centre[1] + radius * np.sin(angles)], axis=1)


def half_disc_scene(angle, way=0.8e-3, seconds=0.25):
    """A half disc on its flat side, with a notch from the middle of that side at `angle` [degrees] to the load."""
    import shapely

    dx = 2.0 * RADIUS / CELLS
    tip = CUT * np.array([np.sin(np.radians(angle)), np.cos(np.radians(angle))])
    notch = shapely.LineString([-0.5 * tip, tip]).buffer(0.7 * dx, cap_style="flat")
    outline = shapely.Polygon(arc(RADIUS, 0.0, 180.0)).difference(notch).exterior.coords[:-1]
    rests = [{"kind": "sphere", "centre": [side * HALF_SPAN, -SMALL_ROLLER], "radius": SMALL_ROLLER}
             for side in (-1, 1)]
    press = {"kind": "sphere", "centre": [0.0, RADIUS + SMALL_ROLLER], "radius": SMALL_ROLLER}
    return scene("half_disc", dx, [polygon(outline)], RADIUS, RADIUS, rests, press, way, seconds, GRIP)


def ring_scene(ratio, way=1.6e-3, seconds=0.3):
    """A ring with a hole of `ratio` times its diameter between two platens."""
    dx = 2.0 * RADIUS / CELLS
    shapes = []
    for begin, end in ((-90.0, 90.0), (270.0, 90.0)):
        outer = arc(RADIUS, begin, end, (0.0, RADIUS))
        inner = arc(ratio * RADIUS, end, begin, (0.0, RADIUS))
        shapes.append(polygon(np.concatenate([outer, inner])))
    wide, thick = 0.6 * RADIUS, 6 * dx
    rest = {"kind": "box", "min": [-wide, -thick], "max": [wide, 0.0]}
    press = {"kind": "box", "min": [-wide, 2.0 * RADIUS], "max": [wide, 2.0 * RADIUS + thick]}
    return scene("split_ring", dx, shapes, RADIUS, 2.0 * RADIUS, [rest], press, way, seconds, GRIP)


def broken(tested):
    """Reading at which the load has fallen to a twentieth of its peak, the last one if it has not: a press stops there,
    before it crushes the parts."""
    peak = tested.force.argmax()
    low = np.flatnonzero(tested.force[peak:] < 0.05 * tested.force[peak])
    return peak + low[0] if len(low) else len(tested.force) - 1


@cache
def half_disc(angle, **options):
    """`Loaded` half disc."""
    return load(half_disc_scene(angle, **options))


@cache
def ring(ratio, **options):
    """`Loaded` ring."""
    return load(ring_scene(ratio, **options))


def cracked_share(tested, ratio):
    """Of a ring at each reading: shares of its section along the load, and of that across, that a crack has opened.

    Of the cells' rows along a section outside the hole, those that have within R / 6 of it a particle with half of its
    cohesion lost and a crack along the section."""
    shares, outside = [], ratio * RADIUS
    place = tested.x - [0.0, RADIUS]
    for along in (1, 0):
        near = (np.abs(place[:, 1 - along]) < RADIUS / 6) & (np.abs(place[:, along]) > outside)
        near &= tested.normal[:, 1 - along] > 0.5
        rows = np.floor(place[:, along] / tested.dx).astype(int)
        cells = 2.0 * (RADIUS - outside) / tested.dx
        shares.append([len(np.unique(rows[near & (damage > 0.5)])) / cells for damage in tested.damage])
    return np.array(shares)
