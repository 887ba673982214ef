"""Entries: what transfers and splines do to motion that they should leave alone."""

import numpy as np

from snowmpm.materials import Elastic
from snowmpm.particles.population import Population
from snowmpm.schemes import BASES, TRANSFERS
from snowmpm.study.atlas.entry import Entry
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.schemes import Scheme, free_solver, lattice

LAW = Elastic(density=250.0, youngs_modulus=3e6, poisson_ratio=0.3)
DX = 0.05
NOISE_STEPS = 1000
LEFT, LOST, RINGS, UNBALANCED, TURN_LOST = 0.01, 0.1, 0.01, 0.1, 0.02
"""Limits of the entries below."""
AMPLITUDE = 1e-4
"""Velocity of waves over their speed: small, so that they are linear."""
CELLS_IN_RADIUS = 5


def noise_left(flip_ratio, transfer, kernel="quadratic"):
    """Share of a motion that alternates from particle to particle, which the grid cannot see, left after 1000 steps."""
    x, volumes = lattice([0.0, 0.0], [8 * DX, 4 * DX], DX)
    sign = (-1.0) ** np.round(2.0 * x / DX - 0.5).sum(axis=1)
    solver = free_solver(x, volumes, LAW, Scheme(transfer, flip_ratio, kernel), DX, reach=8 * DX,
                         velocities=1e-6 * LAW.wave_speed() * np.stack([sign, 0.0 * sign], axis=1))
    start = _kinetic(solver)
    for _ in range(NOISE_STEPS):
        solver.step(solver.stable_dt()[0])
    return (_kinetic(solver) - solver.grid_kinetic_energy()) / start


def _kinetic(solver):
    square = (solver.particles.column("velocity") ** 2).sum(axis=1)
    square += solver.second_moment() * (solver.particles.column("affine") ** 2).sum(axis=1)
    return 0.5 * float(solver.particles.masses() @ square)


def strip(length, scheme, sides, high=2):
    """Solver and states of a strip of `length` [cells] between smooth walls, `high` cells high."""
    x, volumes = lattice([0.0, 0.0], [length * DX, high * DX], DX)
    size = np.array([length + 2.0 if "open" in sides else length, high]) * DX
    solver = scheme.solver(Population(x, volumes, 0), [LAW], dx=DX, origin=np.zeros(2), lower=np.zeros(2), upper=size,
                           gravity=np.zeros(2), sides=[sides, ["slip", "slip"]])
    return solver, ParticleStates(solver)


def wave_lost(wavelength, **scheme):
    """Energy that a standing pressure wave between smooth walls loses in a period; wavelength [cells]."""
    solver, states = strip(0.5 * wavelength, Scheme(**scheme), ["slip", "slip"])
    k = 2.0 * np.pi / (wavelength * DX)
    x, speed = states.reference[:, 0], AMPLITUDE * LAW.wave_speed()
    mode = np.sin(k * x)
    states.set(velocity=speed * np.stack([mode, 0.0 * mode], axis=1))
    if Scheme(**scheme).affine:
        states.set(affine=speed * k * np.cos(k * x)[:, None] * np.array([1.0, 0.0, 0.0, 0.0]))
    dt = 0.3 * DX / LAW.wave_speed()
    largest = 0.0
    for _ in range(round(1.1 * wavelength * DX / LAW.wave_speed() / dt)):
        solver.step(dt)
        if solver.time > 0.75 * wavelength * DX / LAW.wave_speed():  # the second return, a little late on the grid
            largest = max(largest, states.column("velocity")[:, 0] @ mode / (mode @ mode) / speed)
    return 1.0 - largest**2


def ringing(flip_ratio, transfer, kernel="quadratic"):
    """Root mean square error of the pressure from 2 to 14 cells off the wall in a bar of 36 cells that meets it, when
    the front is at cell 30, over the exact one. Steps of C = 0.4, since a longer one rings more."""
    speed = AMPLITUDE * LAW.wave_speed()
    solver, states = strip(36, Scheme(transfer, flip_ratio, kernel, cfl=0.4), ["separate", "open"])
    states.set(velocity=np.tile([-speed, 0.0], (len(states.mass), 1)))
    while solver.time < 30 * DX / LAW.wave_speed():
        solver.step(solver.stable_dt()[0])
    behind = (states.reference[:, 0] > 2 * DX) & (states.reference[:, 0] < 14 * DX)
    stress = -states.column("stress")[behind, 0] / (LAW.density * LAW.wave_speed() * speed)
    return np.sqrt(((stress - 1.0) ** 2).mean())


def spin_lost(flip_ratio, transfer):
    """Share of the angular momentum that a disc of 5 cells in radius loses in a hundredth of a turn."""
    radius = CELLS_IN_RADIUS * DX
    x, volumes = lattice([-radius, -radius], [radius, radius], DX)
    inside = (x**2).sum(axis=1) < radius**2
    x, volumes = x[inside], volumes[inside]
    omega = 1e-2 * LAW.wave_speed() / radius
    solver = free_solver(x, volumes, LAW, Scheme(transfer, flip_ratio), DX, reach=8 * DX,
                         velocities=omega * np.stack([-x[:, 1], x[:, 0]], axis=1))
    if TRANSFERS[transfer].affine:
        ParticleStates(solver).set(affine=np.tile([0.0, -omega, omega, 0.0], (len(x), 1)))
    start = _spin(solver)
    while omega * solver.time < 0.02 * np.pi:
        solver.step(solver.stable_dt()[0])
    return 1.0 - _spin(solver) / start


def _spin(solver):
    x, v, c = (solver.particles.positions(), *(solver.particles.column(name) for name in ("velocity", "affine")))
    x = x - x.mean(axis=0)
    return float(solver.particles.masses() @ (x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0]
                                              + solver.second_moment() * (c[:, 2] - c[:, 1])))


def hat(x):
    """Slope of the linear hat: (x) [cells] -> [1/cell]."""
    return np.where(np.abs(x) < 1.0, -np.sign(x), 0.0)


def averaged_hat(kernel):
    """Slope of the hat averaged over the box of a basis; over a whole cell, of the quadratic spline."""
    box = BASES[kernel].box or 1.0

    def slope(x):
        above, below = (np.maximum(0.0, 1.0 - np.abs(y)) for y in (x + 0.5 * box, x - 0.5 * box))
        return (above - below) / box

    return slope


def cubic(x):
    """Slope of the cubic spline."""
    a = np.abs(x)
    return -np.sign(x) * np.where(a < 1.0, 2.0 * a - 1.5 * a**2, np.where(a < 2.0, 0.5 * (2.0 - a) ** 2, 0.0))


def quadratic_affine(x):
    """What moving least squares take in its place: 4 w (x_i - x_p)."""
    a = np.abs(x)
    return -4.0 * x * np.where(a < 0.5, 0.75 - a**2, np.where(a < 1.5, 0.5 * (1.5 - a) ** 2, 0.0))


SLOPES = {"hat": hat, "linear shape": averaged_hat("linear"), "gimp shape": averaged_hat("gimp"),
          "quadratic shape": averaged_hat("quadratic"), "quadratic affine": quadratic_affine, "cubic shape": cubic}


def unbalanced(spacing, basis):
    """Largest force on an inner node of a lattice under uniform stress, over that on a cut through it, as the lattice
    slides through the grid: the worst of spacings from 0.8 of that given [cells]."""
    worst, offsets = 0.0, np.linspace(0.0, 1.0, 41)[:, None]
    for s in np.linspace(0.8 * spacing, spacing, 21):
        places = s * np.arange(-np.ceil(3.0 / s), np.ceil(3.0 / s) + 1.0) + s * offsets
        worst = max(worst, np.abs(s * SLOPES[basis](places).sum(axis=1)).max())
    return worst


RATIOS = (0.0, 0.5, 0.8, 0.9, 0.95, 0.97, 0.98, 0.99, 0.995, 0.999, 1.0)
ENTRIES = (
    Entry(
        name="null_space_noise", title="Noise in the null space of FLIP",
        scene="A body at rest, 2 x 2 particles in a cell, whose velocities alternate from one to the next",
        seen="The grid does not see it, so nothing takes it away: it stays for ever with all of FLIP",
        cure='transfer = "apic", or a lower flip_ratio', parameter="flip_ratio", unit="", values=RATIOS[4:],
        settings={"flip": {"transfer": "flip"}, "aflip": {"transfer": "aflip"},
                  "flip cubic": {"transfer": "flip", "kernel": "cubic"}, "apic": {"transfer": "apic"},
                  "pic": {"transfer": "pic"}},
        symptom="share of the noise left after 1000 steps", limit=LEFT, measure=noise_left, shown="flip", cured="apic",
        resolution=2e-4),
    Entry(
        name="ringing", title="Ringing behind a front",
        scene="A bar of 36 cells that meets a smooth wall; the front is at cell 30",
        seen="The pressure far behind the front still swings, by a hundredth or two, where nothing damps it",
        cure='transfer = "apic"', parameter="flip_ratio", unit="", values=RATIOS,
        settings={"flip": {"transfer": "flip"}, "aflip": {"transfer": "aflip"},
                  "flip cubic": {"transfer": "flip", "kernel": "cubic"}, "apic": {"transfer": "apic"},
                  "pic": {"transfer": "pic"}},
        symptom="error of the pressure behind the front", limit=RINGS, measure=ringing, shown="flip",
        cured="apic"),
    Entry(
        name="damped_waves", title="Waves that the transfer damps",
        scene="A standing pressure wave between smooth walls, 2 cells high",
        seen="PIC takes the energy of every wave that a scene resolves, APIC that of the short ones",
        cure='transfer = "aflip", or a smaller solver.dx', parameter="wavelength",
        unit="cells", values=(4.0, 6.0, 8.0, 12.0, 16.0, 24.0, 32.0, 48.0, 64.0), fails="below",
        settings={"apic": {"transfer": "apic"}, "apic cubic": {"transfer": "apic", "kernel": "cubic"},
                  "pic": {"transfer": "pic"}, "flip 0.95": {"transfer": "flip", "flip_ratio": 0.95},
                  "flip 0.99": {"transfer": "flip", "flip_ratio": 0.99},
                  "aflip 0.97": {"transfer": "aflip", "flip_ratio": 0.97},
                  "aflip 0.99": {"transfer": "aflip", "flip_ratio": 0.99}},
        symptom="energy lost in a period", limit=LOST, measure=wave_lost, shown="pic", cured="aflip 0.99",
        resolution=0.08),  # a strip of another length has its particles elsewhere in their cells
    Entry(
        name="lost_spin", title="Spin that the transfer takes",
        scene="A free disc of 5 cells in radius that turns, for a hundredth of a turn",
        seen="A particle that hands on its velocity alone loses the angular momentum about itself: blocks stop rolling",
        cure='transfer = "apic" or "aflip"', parameter="flip_ratio", unit="", values=RATIOS, fails="below",
        settings={"flip": {"transfer": "flip"}, "aflip": {"transfer": "aflip"}, "pic": {"transfer": "pic"},
                  "apic": {"transfer": "apic"}},
        symptom="share of the angular momentum lost", limit=TURN_LOST, measure=spin_lost, shown="flip", cured="aflip",
        resolution=2e-3),
    Entry(
        name="cell_crossing", title="Forces out of nothing as particles cross cells",
        scene="A line of particles under uniform stress that slides through the grid (exact sums, no run)",
        seen="Inner nodes, which should feel nothing, are pushed to and fro: fully with a linear basis, whose slope"
             " jumps at a cell's edge (hat; kernel = \"linear\" rounds the jump off over a sixteenth of a cell), less"
             " with the hat over boxes of half a cell (kernel = \"gimp\"; boxes of a whole cell are the quadratic"
             " spline), and with any basis when particles lie far apart",
        cure='solver.particles_per_cell = 4 (9) in 2-D, 8 (27) in 3-D, or kernel = "cubic" with gradient = "shape"',
        parameter="distance between particles", unit="cells", values=(0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.2),
        settings={basis: {"basis": basis} for basis in SLOPES},
        symptom="force on an inner node over that of a cut", limit=UNBALANCED, measure=unbalanced, shown="linear shape",
        cured="cubic shape"),
)
