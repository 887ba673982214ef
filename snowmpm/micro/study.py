"""All that `snowmpm micro` says of a sample."""

import numpy as np

from snowmpm.micro import pores
from snowmpm.micro.permeability import calonne, permeability


def examine(sample, axes=(0, 1, 2), walls=False, tolerance=1e-4):
    """(record, `Permeability`) of a `Sample`: geometry, and permeability along the axes, of the pores that lead through
    along each. record: numbers by name in SI units."""
    record = sample.numbers()
    found = _along(sample, axes, walls, tolerance)
    record["permeability"] = found.tensor.tolist()
    record["permeability_mean"] = found.mean
    if len(axes) == 3:
        record["asymmetry"] = found.asymmetry
    record["tortuosity"] = found.tortuosity.tolist()
    fit = calonne(record["equivalent_radius"], record["density"])
    record |= {"permeability_calonne": float(fit), "permeability_over_calonne": found.mean / float(fit),
               "steps": found.steps.tolist(), "remaining": found.remaining.tolist()}
    return record, found


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
