"""A step of water through pores: rest, Darcy's law, conservation, and percolation through pores that hold air."""

import numpy as np
import pytest

from snowmpm.components.pore_water.flow import Fluid, seep
from snowmpm.water.cells import MaterialCells
from snowmpm.water.permeability import IRREDUCIBLE, relative_permeability

G, DX, K, POROSITY = 9.81, 0.05, 1e-9, 0.6
DOWN = np.array([0.0, -G])
WATER = Fluid()
SNOW = Fluid(suction=0.0)


class Column:
    """Cells of a column of snow, n high, and water in it."""

    def __init__(self, n, fluid, pressure=0.0, saturation=None):
        self.cells = MaterialCells(np.stack([np.zeros(n, int), np.arange(n)], axis=1))
        self.fluid, self.n = fluid, n
        self.pores = np.full(n, POROSITY * DX**2)
        self.pressure = np.broadcast_to(np.asarray(pressure, float), n).copy()
        self.water = fluid.content(self.pressure, self.pores)
        if saturation is not None:
            self.water = saturation * self.pores
        self.out = 0.0

    def side(self, sign):
        return (self.cells.border_axis == 1) & (self.cells.border_sign == sign)

    def step(self, dt, drained=(), rain=0.0, share=0.0, permeability=K):
        """drained: signs of the ends that let water out."""
        faces = np.any([self.side(sign) for sign in drained], axis=0) if drained else np.zeros(len(self.cells.border),
                                                                                                bool)
        self.water[-1] += rain * dt * DX
        done = seep(self.cells, DX, self.fluid, dt, water=self.water, pores=self.pores, before=self.pressure,
                    permeability=np.full(self.n, permeability), drained=faces, gravity=DOWN,
                    density=np.full(self.n, 900.0), share=share)
        self.water, self.pressure, self.out = done.water, done.pressure, self.out + done.out.sum()
        return done


@pytest.mark.parametrize("fluid", [WATER, SNOW])
def test_rest(fluid):
    """Below a free surface water stays at rest under its weight."""
    depth = DX * (20 - np.arange(20) - 0.5)
    column = Column(20, fluid, pressure=1000.0 * G * depth)
    start = column.water.copy()
    for _ in range(20):
        column.step(0.1, drained=(1,), share=1.4)
    np.testing.assert_allclose(column.pressure, 1000.0 * G * depth, rtol=1e-7)
    np.testing.assert_allclose(column.water, start, rtol=1e-12)


def test_the_pressure_is_that_of_the_water_in_the_pores():
    """Of two sealed cells, one over the other, joined for the time dt, by Euler's backward rule: with d = p_1 - p_2 -
    rho_w g dx, the pressure that drives water up,

        P / K_w (p_1' - p_1) = -dt T d' = -P / K_w (p_2' - p_2),    d' = d / (1 + 2 dt T K_w / P),    T = K / mu

    here a half of it: 2500 Pa go from one to the other. Then p' = K_w (W' / P - 1) in both, and pores that lose dV
    press by K_w dV / P. Asked to 1e-9 and 1e-4; 1.02 of the capacity P / K_w gives 2475 Pa."""
    head = 1000.0 * G * DX
    column = Column(2, WATER, pressure=[1e4 + head, 0.0])
    dt = 0.5 * column.pores[0] / WATER.bulk_modulus * WATER.viscosity / K
    column.step(dt)
    np.testing.assert_allclose(column.pressure, [7500.0 + head, 2500.0], rtol=1e-9)
    np.testing.assert_allclose(WATER.bulk_modulus * (column.water / column.pores - 1.0), column.pressure, rtol=1e-9)
    column.pores *= 1.0 - 1e-5
    column.step(1e6 * dt)
    np.testing.assert_allclose(column.pressure, [5000.0 + head + 22000.0, 5000.0 + 22000.0], rtol=1e-4)


def test_steady_speed_is_darcys():
    """A saturated column that drains at its foot, fed at its top, carries K rho g / mu: exactly (P10)."""
    column = Column(30, WATER)
    for _ in range(10):
        done = column.step(1e3, drained=(1, -1))
    speed = done.out[column.side(-1)].sum() / 1e3 / DX
    assert speed == pytest.approx(K * 1000.0 * G / WATER.viscosity, rel=1e-9)
    assert done.out[column.side(1)].sum() == pytest.approx(-done.out[column.side(-1)].sum(), rel=1e-9)


@pytest.mark.parametrize("share", [0.0, 1.4])
@pytest.mark.parametrize("fluid", [WATER, SNOW])
def test_water_is_conserved(fluid, share):
    rng = np.random.default_rng(5)
    column = Column(25, fluid, pressure=1e4 * rng.random(25))
    if fluid.suction is not None:
        column.water *= rng.uniform(0.3, 1.0, 25)
    start = column.water.sum()
    for k in range(60):
        column.step(10.0 ** rng.uniform(-3.0, 2.0), drained=(1, -1), share=share)
        assert column.water.sum() + column.out == pytest.approx(start, rel=1e-13), k
        assert (column.water > 0.0).all() and column.pressure.min() >= (-1e4 if fluid.suction is None else 0.0)


def percolating(n, saturation, dt):
    """Column without water, under rain at the rate that `saturation` carries by its weight, until the front should
    be half-way down."""
    rate = float(relative_permeability(saturation)) * K * 1000.0 * G / SNOW.viscosity
    column = Column(n, SNOW, saturation=np.zeros(n))
    speed = rate / (POROSITY * saturation)
    steps = round(0.5 * n * DX / speed / dt)
    for _ in range(steps):
        column.step(dt, drained=(-1,), rain=rate)
    return column, rate * steps * dt * DX, speed * steps * dt


def test_percolation_front():
    """Colbeck's kinematic wave: behind the front, the saturation that carries the rain; the front at rate / (n S)."""
    column, fallen, way = percolating(60, 0.5, 4.0)
    saturation = column.water / column.pores
    assert column.water.sum() == pytest.approx(fallen, rel=1e-12) and column.out == 0.0
    behind = DX * (60 - np.arange(60) - 0.5) < 0.8 * way
    behind[-1] = False  # where rain came in at the start of the step
    np.testing.assert_allclose(saturation[behind], 0.5, rtol=2e-3)
    front = DX * (60 - np.arange(60)[saturation > 0.25].min())
    assert front == pytest.approx(way, abs=1.5 * DX)


def test_water_pools_on_a_sealed_ground():
    """Rain on snow with a sealed ground: what is full stands at rest under its weight, and holds all the rain."""
    column = Column(20, SNOW, saturation=np.full(20, IRREDUCIBLE))
    rate, dt, start = 2e-4, 4.0, column.water.sum()
    for _ in range(200):
        column.step(dt, rain=rate)
    for _ in range(800):
        column.step(3.0 * dt)
    assert column.water.sum() == pytest.approx(start + 200 * rate * dt * DX, rel=1e-12)
    full = column.water >= column.pores * (1.0 - 1e-9)
    assert 4 <= full.sum() <= 8 and full[: full.sum()].all()
    foot = column.pressure[: full.sum()]
    np.testing.assert_allclose(-np.diff(foot) / DX, 1000.0 * G, rtol=1e-2)
    assert (column.pressure[full.sum() :] == 0.0).all()


def test_a_seepage_face_lets_nothing_in():
    """Air behind a border: dry snow below it takes up no water from outside."""
    column = Column(10, SNOW, saturation=np.full(10, 0.5))
    start = column.water.sum()
    for _ in range(100):
        done = column.step(10.0, drained=(1, -1))
        assert (done.out >= 0.0).all()
    assert column.out > 0.0 and column.water.sum() + column.out == pytest.approx(start, rel=1e-13)
    # What capillary forces hold stays
    assert (column.water / column.pores > IRREDUCIBLE * (1.0 - 1e-9)).all()
