"""How a particle fills its row (`sph.rows`) from its state."""

import functools
from typing import Any, NamedTuple

from snowmpm.compiler import ti
from snowmpm.materials.spectral import eigen

LARGEST_GROWTH = 2.0
"""J at which the volume that a particle stands for in sums stops to grow: one that flies alone does not fill the air
around it."""


class Shown(NamedTuple):
    """What a particle shows its neighbours, within a kernel: position [cells, from its block]; velocity [m/s] and its
    gradient [m/s per cell]; Kirchhoff stress [Pa]; J, present over reference volume, of which `LARGEST_GROWTH` at most
    counts; reference volume over cell volume; reference density [kg/m3]; speed of waves [m/s]."""

    x: Any
    v: Any
    L: Any
    tau: Any
    ratio: Any
    volume: Any
    density: Any
    speed: Any


@functools.cache
def row_functions(layout, row_layout, real, form, tension, volumes):
    """Taichi function `store_row(...)`, which writes what particle i shows its neighbours to row i of `source`.

    form: of the momentum sum, which determines the measure of S; tension: factor and form of the artificial stress;
    volumes: "follow" J, or are "constant" in all sums.
    """
    dim, at, entries = layout.dim, row_layout.at, row_layout.entries
    epsilon, kind = tension

    @ti.func
    def artificial_pressure(p):
        """R = -epsilon <-p> I, of the mean tension -p (Bui & Nguyen 2021, Eq. 118)."""
        R = ti.Vector.zero(real, row_layout.n_stress)
        for a in ti.static(range(dim)):
            R[a] = -epsilon * ti.max(0.0, -p)
        return R

    @ti.func
    def artificial_stress(S):
        """R = -epsilon sum_k <S_k> n_k n_k^T over the principal axes in tension (Gray et al. 2001)."""
        whole = ti.Vector.zero(real, 4 if ti.static(dim == 2) else 6)
        for k in ti.static(range(row_layout.n_stress)):
            whole[entries[k]] = S[k]
        values, axes = eigen(whole)
        R = ti.Vector.zero(real, row_layout.n_stress)
        for k in ti.static(range(row_layout.n_stress)):
            a, b = ti.static(row_layout.pairs[k])
            for m in ti.static(range(3)):
                R[k] -= epsilon * ti.max(0.0, values[m]) * axes[a, m] * axes[b, m]
        return R

    @ti.func
    def store_row(i, source: ti.template(), shown: ti.template(), back):
        """Write row i of `source` (`sph.rows`) from what a particle shows. back: K^-1 (dim, dim), which multiplies S in
        a `full` layout only."""
        row = ti.Vector.zero(real, row_layout.source_width)
        J, density = ti.min(shown.ratio, LARGEST_GROWTH), shown.density
        if ti.static(volumes == "constant"):
            J = shown.ratio * 0.0 + 1.0
        scale = J / (density * density) if ti.static(form in ("density", "corrected")) else 1.0 / J
        for a in ti.static(range(dim)):
            row[at["x"] + a], row[at["v"] + a] = shown.x[a], shown.v[a]
        S = ti.Vector([scale * shown.tau[entries[k]] for k in ti.static(range(row_layout.n_stress))])
        if ti.static(row_layout.full):
            whole = ti.Matrix.zero(real, dim, dim)
            for k in ti.static(range(row_layout.n_stress)):
                a, b = ti.static(row_layout.pairs[k])
                whole[a, b], whole[b, a] = S[k], S[k]
            whole = whole @ back
            for a in ti.static(range(dim)):
                for b in ti.static(range(dim)):
                    row[at["S"] + a * dim + b] = whole[a, b]
        else:
            for k in ti.static(range(row_layout.n_stress)):
                row[at["S"] + k] = S[k]
        if ti.static(row_layout.tension):
            R = ti.Vector.zero(real, row_layout.n_stress)
            if ti.static(kind == "pressure"):
                R = artificial_pressure(-scale * (shown.tau[0] + shown.tau[1] + shown.tau[2]) / 3.0)
            else:
                R = artificial_stress(S)
            for k in ti.static(range(row_layout.n_stress)):
                row[at["R"] + k] = R[k]
        if ti.static(row_layout.ordered):
            for k in ti.static(range(row_layout.n_stress)):
                a, b = ti.static(row_layout.pairs[k])
                row[at["D"] + k] = 0.5 * (shown.L[a, b] + shown.L[b, a])
        row[at["m"]], row[at["V"]] = density * shown.volume, J * shown.volume
        row[at["z"]] = density / J * shown.speed
        source[i] = row

    return store_row
