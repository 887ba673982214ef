"""Permeability of a sample: how much fluid a pressure gradient drives through it.

    q = -k / mu grad p,   k_ij = nu q_i / F_j in lattice units, times the square of the voxel size

for a force F along each of the axes (Darcy 1856; upscaled as by Sun, Andrade and Rudnicki 2011, doi:10.1002/nme.3220).
A run goes on until the flux, extrapolated by its last three values as a decaying exponential, changes by less than a
tolerance: what counts is the answer, not the field.
"""

import warnings
from dataclasses import dataclass, field

import numpy as np

from snowmpm.micro.pore_lattice import pore_lattice
from snowmpm.micro.stokes_flow import StokesFlow
from snowmpm.stages import stage

TAU = 3.0
"""Relaxation time of the even part: the answer does not depend on it, the number of steps does."""

FORCE = 1e-5
"""In lattice units; the flow is linear in it."""

WINDOW = 50
"""Pairs of steps between two looks at the flux."""

MOST_STEPS = 200_000


@dataclass(frozen=True)
class Permeability:
    """tensor (3, 3) [m2], rows: direction of the flux, columns: of the force; NaN for axes not asked for. tortuosity
    (3,): mean speed over mean velocity along the force. steps (3,). remaining (3,): estimated change of the flux still
    to come, relative. speeds: by axis, |u| / F in lattice units at the pore voxels (nx, ny, nz), zero in the ice."""

    tensor: np.ndarray
    tortuosity: np.ndarray
    steps: np.ndarray
    remaining: np.ndarray
    speeds: dict = field(default_factory=dict)

    @property
    def mean(self):
        """Mean of the diagonal over the axes that were asked for [m2]."""
        return float(np.nanmean(np.diag(self.tensor)))

    @property
    def asymmetry(self):
        """Largest |k_ij - k_ji| over the mean; 0 of a tensor that is symmetric."""
        return float(np.nanmax(np.abs(self.tensor - self.tensor.T)) / max(self.mean, 1e-300))


def permeability(pores, voxel_size, axes=(0, 1, 2), walls=False, tolerance=1e-4, tau=TAU, precision="f32",
                 slide=(0, 0)):
    """`Permeability` of an image (nx, ny, nz), True in pores, with voxels of `voxel_size` [m].

    axes: of the force. walls: no-slip walls at the sides along it; by default all sides are periodic. slide: shift of
    the image above z along x and y, in voxels, of a cell that is sheared. Memory is asked for before. InputError when
    there is too little.
    """
    tensor = np.full((3, 3), np.nan)
    tortuosity, steps, remaining = np.full(3, np.nan), np.zeros(3, int), np.zeros(3)
    speeds = {}
    lattices = {}
    for axis in axes:
        sides = tuple(walls and other != axis for other in range(3))
        if not pores.any() or (pores.all() and not any(sides)):  # nothing flows, or nothing holds it
            tensor[:, axis] = 0.0
            tensor[axis, axis] = np.inf if pores.any() else 0.0
            continue
        if sides not in lattices:
            lattices[sides] = pore_lattice(pores, sides, slide)
        lattice = lattices[sides]
        flow = StokesFlow(lattice, FORCE * np.eye(3)[axis], tau=tau, precision=precision)
        remaining[axis] = _to_rest(flow, axis, tolerance)
        u, steps[axis] = flow.velocity() / FORCE, flow.steps
        tensor[:, axis] = flow.viscosity * u.sum(axis=0) / pores.size * voxel_size**2
        speed = np.linalg.norm(u, axis=1)
        tortuosity[axis] = speed.mean() / u[:, axis].mean() if u[:, axis].mean() > 1e-9 * speed.max() else np.inf
        speeds[axis] = np.zeros(pores.shape, np.float32)
        speeds[axis][tuple(lattice.nodes.T)] = speed
    return Permeability(tensor, tortuosity, steps, remaining, speeds)


def _to_rest(flow, axis, tolerance):
    """Advance until the flux no longer changes; -> the relative change still to come."""
    seen, left, calm = [], np.inf, 0
    with stage(f"flow along {'xyz'[axis]}") as now:
        while flow.steps < MOST_STEPS and calm < 2:
            flow.advance(WINDOW)
            seen.append(float(flow.flux()[axis]))
            now.done = flow.steps
            if len(seen) < 3:
                continue
            before, last = seen[-2] - seen[-3], seen[-1] - seen[-2]
            rate = last / before if before else 0.0
            # A decay that is none yet: the change of a window, many times
            left = abs(last) * (rate / (1.0 - rate) if 0.0 < rate < 0.999 else 1e3)
            left /= max(abs(seen[-1]), 1e-300)
            if last == 0.0 or abs(last) < 1e-12 * abs(seen[-1]):
                left = 0.0
            calm = calm + 1 if left < tolerance else 0
    if calm < 2:
        warnings.warn(f"flow along {'xyz'[axis]} has not settled in {flow.steps} steps: its flux may still change by"
                      f" {100.0 * min(left, 1.0):.2g} %", stacklevel=3)
    return left


CALONNE = "Calonne et al. (2012), doi:10.5194/tc-6-939-2012"
CALONNE_SCATTER = 1.5
"""Factor by which the 35 samples of the fit scatter about it."""


def calonne(radius, density):
    """Permeability of snow [m2] from the equivalent sphere radius [m] and the density [kg/m3]: the fit to 35 samples of
    all kinds, k = 3.0 r^2 exp(-0.0130 rho) (Calonne et al. 2012, doi:10.5194/tc-6-939-2012)."""
    return 3.0 * radius**2 * np.exp(-0.0130 * density)
