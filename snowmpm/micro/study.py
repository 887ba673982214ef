"""All that `snowmpm micro` says of a sample."""

import warnings

import numpy as np

from snowmpm.micro import pores
from snowmpm.micro.elasticity import elastic_tensor
from snowmpm.micro.permeability import CALONNE_SCATTER, calonne, permeability

UNITS = {"voxels": "1", "size": "m", "density": "kg/m3", "porosity": "1", "connected_porosity": "1",
         "surface_per_volume": "1/m", "surface_per_mass": "m2/kg", "equivalent_radius": "m", "grains": "1",
         "permeability": "m2", "permeability_mean": "m2", "asymmetry": "1", "spread_of_axes": "1", "tortuosity": "1",
         "permeability_calonne": "m2", "permeability_calonne_scatter": "1", "permeability_over_calonne": "1",
         "steps": "1", "remaining": "1", "stiffness": "Pa", "youngs_modulus": "Pa", "poisson_ratio": "1",
         "confined_modulus": "Pa", "stiffness_imbalance": "1"}
"""Of the numbers of `examine`, by name."""

SNOW = (1.0, 150.0)
"""Specific surface of snow per mass [m2/kg]: coarse melt forms to fresh dendrites, with room on both sides."""

APART = 0.2
"""Difference of the permeabilities along the axes, over their mean, from which on something is said of it."""


def examine(sample, axes=(0, 1, 2), walls=False, tolerance=1e-4, stiffness=False):
    """(record, `Permeability`) of a `Sample`: geometry, and permeability along the axes, of the pores that lead through
    along each. record: numbers by name in SI units (`UNITS`); surface_per_volume is per volume of snow. stiffness: the
    elastic tensor of the ice too. Warns of a voxel size that is not one of snow."""
    record = sample.numbers()
    if doubt := unit_doubt(record["surface_per_mass"], sample.voxel_size):
        warnings.warn(doubt, stacklevel=2)
    found = _along(sample, axes, walls, tolerance)
    record["permeability"] = found.tensor.tolist()
    record["permeability_mean"] = found.mean
    if len(axes) == 3:
        record["asymmetry"] = found.asymmetry
    along = np.diag(found.tensor)[list(axes)]
    record["spread_of_axes"] = float(np.ptp(along) / found.mean) if np.isfinite(along).all() and found.mean else 0.0
    record["tortuosity"] = found.tortuosity.tolist()
    fit = calonne(record["equivalent_radius"], record["density"])
    record |= {"permeability_calonne": float(fit), "permeability_calonne_scatter": CALONNE_SCATTER,
               "permeability_over_calonne": found.mean / float(fit),
               "steps": found.steps.tolist(), "remaining": found.remaining.tolist()}
    if stiffness:
        record |= _stiffness(sample)
    return record, found


def _stiffness(sample):
    """What the record says of the elastic tensor."""
    elastic = elastic_tensor(sample.ice)
    young, poisson = elastic.isotropic
    return {"stiffness": elastic.stiffness.tolist(), "youngs_modulus": float(young), "poisson_ratio": float(poisson),
            "confined_modulus": elastic.confined.tolist(), "stiffness_imbalance": float(elastic.remaining.max())}


def unit_doubt(surface_per_mass, voxel_size):
    """What is likely wrong with a voxel size [m] for which the specific surface [m2/kg] is not one of snow; None."""
    low, high = SNOW
    if low <= surface_per_mass <= high:
        return None
    says = (f"specific surface {surface_per_mass:.3g} m2/kg: that of snow is {low:g} to {high:g} m2/kg;"
            " --voxel-size is in metres")
    for unit, scale in (("millimetres", 1e-3), ("micrometres", 1e-6)):
        if low <= surface_per_mass / scale <= high:
            return f"{says}, and {voxel_size:g} was likely meant in {unit}: --voxel-size {voxel_size * scale:g}"
    return f"{says}: is it right, and is --phase that of ice?"


def anisotropy_remark(record):
    """What permeabilities that differ along the axes mean; None where they hardly do.

    A sample of n grains scatters by about 1 / sqrt(n). Differences of less than three times that may be chance.
    """
    apart, grains = record["spread_of_axes"], record["grains"]
    if apart < APART:
        return None
    says = f"the permeabilities along the axes are {100.0 * apart:.0f} % apart"
    if apart < 3.0 / np.sqrt(max(grains, 1e-9)):
        return (f"{says}: the sample is too small to tell whether the snow is. It holds about {grains:.0f} grains; from"
                f" about {9.0 / apart**2:.0f} on it could tell")
    return f"{says}: more than chance in a sample of about {grains:.0f} grains; the snow has a direction"


def _along(sample, axes, walls, tolerance):
    """Pores that lead nowhere carry no flow: each axis has its own."""
    parts = []
    for axis in axes:
        through = pores.connected_pores(~sample.ice, axis)
        parts.append(permeability(through, sample.voxel_size, (axis,), walls, tolerance))
    whole = parts[0]
    for axis, part in zip(axes[1:], parts[1:], strict=True):
        for mine, its in ((whole.tensor.T, part.tensor.T), (whole.tortuosity, part.tortuosity),
                          (whole.steps, part.steps), (whole.remaining, part.remaining)):
            mine[axis] = its[axis]
        whole.speeds.update(part.speeds)
    missing = np.isinf(whole.tortuosity)
    whole.tortuosity[missing] = np.nan
    return whole
