"""Diffusion through material cells, implicit in time: heat, vapour, or pore pressure in a skeleton at rest.

    C du/dt = div (c grad u) + s,   (V C / dt) (u' - u) = -sum_faces Q(u') + V s        (backward Euler)

C: capacity per volume, c: conductivity, V: volume of the material in a cell, Q: `flux.TwoPointFlux`. First order in
time, second in space on full cells.
"""

import numpy as np

from snowmpm.water.flux import TwoPointFlux, solve


def diffuse(cells, dx, values, dt, *, volume, capacity, conductivity, held=None, value=0.0, source=0.0):
    """One step of dt [s] -> (new values (cells,), flux out of each border face).

    values, volume [m3], capacity, conductivity, source (cells,), or numbers for the last three. held (border faces,)
    bool: faces with the prescribed `value`; through the others nothing flows. In 2-D per metre of width.
    """
    n, flux = len(cells), TwoPointFlux(cells, dx)
    capacity, conductivity, source = (np.broadcast_to(np.asarray(a, float), n)
                                      for a in (capacity, conductivity, source))
    held = np.zeros(len(cells.border), bool) if held is None else held
    inner = flux.conductances(conductivity)
    border = np.where(held, flux.border_conductances(conductivity), 0.0)
    stored = volume * capacity / dt
    given = np.bincount(cells.border, border * value, n)
    new = solve(flux.matrix(stored, inner, border), stored * values + volume * source + given, values)
    return new, border * (new[cells.border] - value)
