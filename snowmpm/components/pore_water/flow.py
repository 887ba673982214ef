"""One implicit step of water through the pores of material cells.

A cell of pore volume P holds the water volume W, at the density of no pressure. Where water fills the pores,

    p = K_w (W / P - 1)                                                             (storage n / K_w, Nøst 2019, 3.34)

and elsewhere p = -suction: air, at the pressure 0, is in the rest of them. Through a face, per area,

    q = -(K k_r / mu) (grad p - rho_w g) - b grad (p' - p),    b = max(0, s dt / rho - K / (2 mu))

p' the pressure at the end of the step, K k_r / mu of the two cells in series, k_r that of the cell upstream. Then
W' = W - dt sum Q: what leaves a cell enters its neighbour, so water is conserved to round-off whatever a solver leaves.

The second term stands for the relative motion of what carries the pressure: the response of the skeleton's velocity to
p' - p in the next step of an explicit momentum equation, dt / rho grad (p' - p). For a share s large enough, such a
coupling is stable at any compressibility and permeability (`step`). It is 0 where the pressure is steady. At a
free surface that is sealed, the skeleton gives way and water does not leave: there the cell keeps what this flux is
worth as a `yielded` volume, b (p - p_start) 2 A / d dt in all, that counts as pores of its own.

Which cells are full is found by iteration, each from its own inequality: p >= -suction in full cells, W <= P (1 -
suction / K_w) in the others. Faces to the outside let water out only, unless the pores are always full (no suction
given): then what is outside is water, too.
"""

from dataclasses import dataclass

import numpy as np

from snowmpm.annotations import Floats
from snowmpm.water.flux import TwoPointFlux, solve
from snowmpm.water.permeability import IRREDUCIBLE, relative_permeability

MOST_ROUNDS = 12
"""Rounds of the search for the full cells; what is left open is found in the next step, and no water is lost."""

FULL = 1e-12
"""Share of the pores that round-off may leave open in a full cell."""


@dataclass(frozen=True)
class Fluid:
    """Water: density rho_w [kg/m3], bulk modulus K_w [Pa], dynamic viscosity mu [Pa s]; suction [Pa]: the largest that
    pores hold before air enters, None where they are always full."""

    density: float = 1000.0
    bulk_modulus: float = 2.2e9
    viscosity: float = 1.792e-3
    suction: float | None = None

    def content(self, pressure: Floats, pores: Floats) -> Floats:
        """Water volume [m3] that fills pores at a pressure."""
        return pores * (1.0 + pressure / self.bulk_modulus)


@dataclass(frozen=True)
class Seepage:
    """What a step did: water (cells,) [m3], pressure [Pa] and yielded [m3] at its end, out (border faces,) [m3] that
    left through each, full (cells,) whether water fills the pores, rounds of the search."""

    water: Floats
    pressure: Floats
    yielded: Floats
    out: Floats
    full: Floats
    rounds: int


def seep(cells, dx, fluid, dt, *, water, pores, before, permeability, drained, gravity, density, share=0.0, free=False,
         yielded=0.0):
    """`Seepage` over dt [s].

    water, pores (cells,) [m3]; before (cells,): the pressure p at the start [Pa]; permeability (cells,) K [m2]; drained
    (border faces,) bool: those with p = 0 behind them; gravity (dim,) [m/s2]; density (cells,): of the mixture rho
    [kg/m3]; share: s above; free (border faces,) bool: where the skeleton may give way; yielded (cells,) [m3]: of the
    last step.
    """
    flux, n = TwoPointFlux(cells, dx), len(cells)
    floor = -np.inf if fluid.suction is None else -fluid.suction
    head = fluid.density * dx * gravity[cells.axis]
    border_head = 0.5 * fluid.density * dx * gravity[cells.border_axis] * cells.border_sign
    mobility = permeability / fluid.viscosity
    saturation = np.minimum(water / pores, 1.0)
    yielding = relative_permeability(saturation)
    inner_all, border_all = flux.conductances(mobility), flux.border_conductances(mobility)
    # Drainage within the step does half of what the second term is for; where nothing drains, it does all
    whole = share * dt / density
    slack = np.maximum(whole - 0.5 * mobility, 0.0)
    resting, border_resting = flux.conductances(slack), flux.border_conductances(slack)
    held_back = flux.border_conductances(whole)
    capacity = pores / fluid.bulk_modulus / dt
    start = fluid.bulk_modulus * ((water - yielded) / pores - 1.0)
    full = np.ones(n, bool) if fluid.suction is None else start >= floor - FULL * fluid.bulk_modulus
    pressure, opened = np.where(full, before, floor), drained.copy()
    seen, rounds = set(), 0
    while True:
        rounds += 1
        inner = inner_all * _upstream(cells, full, yielding, pressure, head)
        border = np.where(opened, border_all * np.where(full, 1.0, yielding)[cells.border], 0.0)
        both = full[cells.first] & full[cells.second]
        slow = np.where(both, resting, 0.0)
        border_slow = np.where(full[cells.border], np.where(opened, border_resting, free * held_back), 0.0)
        pressure = _pressure(flux, full, floor, capacity, start, before, (inner, slow), (border, border_slow),
                             inner * head, border * border_head)
        through = inner * (pressure[cells.first] - pressure[cells.second] + head)
        change = pressure - before
        through += slow * (change[cells.first] - change[cells.second])
        given = border_slow * change[cells.border]
        out = border * (pressure[cells.border] + border_head) + np.where(opened, given, 0.0)
        if fluid.suction is None:
            break
        new = water - dt * flux.outflow(through, out)
        # Full cells whose pressure falls let air in; others that overflow are full
        room = fluid.content(floor, pores) * (1.0 + FULL)
        now = np.where(full, pressure > floor, new - yielded > room)
        open_now = drained & (pressure[cells.border] + border_head > 0.0)
        settled = np.array_equal(now, full) and np.array_equal(open_now, opened)
        state = now.tobytes() + open_now.tobytes()
        if settled or rounds == MOST_ROUNDS or state in seen:
            break
        seen.add(state)
        full, opened = now, open_now
    if fluid.suction is not None:
        through, out = _available(cells, n, dt, np.maximum(water - IRREDUCIBLE * pores, 0.0), through, out)
        pressure = np.maximum(pressure, floor)  # of cells that the search left open
    kept = dt * np.bincount(cells.border, np.where(opened, 0.0, given), n)
    return Seepage(water - dt * flux.outflow(through, out), pressure, np.where(full, yielded + kept, 0.0), dt * out,
                   full, rounds)


def _upstream(cells, full, yielding, pressure, head):
    """k_r of the cell that each face takes its water from."""
    forward = pressure[cells.first] - pressure[cells.second] + head > 0.0
    source = np.where(forward, cells.first, cells.second)
    return np.where(full[source], 1.0, yielding[source])


def _pressure(flux, full, floor, capacity, start, before, inner, border, inner_head, border_head):
    """Pressure of all cells: solved in full ones, `floor` in the others."""
    cells = flux.cells
    (inner, slow), (border, border_slow) = inner, border
    pressure = np.where(full, 0.0, floor)
    pulled = flux.outflow(inner_head, border_head)
    right = capacity * start - pulled + flux.outflow(slow * (before[cells.first] - before[cells.second]),
                                                     border_slow * before[cells.border])
    matrix = flux.matrix(capacity, inner + slow, border + border_slow)
    if full.all():
        return solve(matrix, right, before)
    rows = np.flatnonzero(full)
    if len(rows):
        right -= matrix @ pressure  # those that are not full
        pressure[rows] = solve(matrix[rows][:, rows], right[rows], before[rows])
    return pressure


def _available(cells, n, dt, most, through, out):
    """Fluxes cut back so that no cell gives more than `most` (cells,) [m3] in dt."""
    leaving = (np.bincount(cells.first, np.maximum(through, 0.0), n)
               + np.bincount(cells.second, np.maximum(-through, 0.0), n)
               + np.bincount(cells.border, np.maximum(out, 0.0), n)) * dt
    kept = np.ones(n)
    short = leaving > most
    kept[short] = most[short] / leaving[short]
    return (through * kept[np.where(through > 0.0, cells.first, cells.second)],
            out * np.where(out > 0.0, kept[cells.border], 1.0))
