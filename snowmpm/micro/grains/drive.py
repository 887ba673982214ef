"""A periodic cell of grains that is driven: strain rates along some axes, stresses along the others."""

import numpy as np

GAIN = 0.1
"""Share of the missing strain, as the contacts' stiffness has it, that is made up for in a step of the control."""

HABIT = 0.05
"""Share of that rate which becomes the axis's usual one: without it a steady flow would need a missing stress."""

EVERY = 20
"""Steps between two looks at the stress."""


def drive(cell, strain, rates=(None, None, None), stresses=(None, None, None), fastest=1.0, watch=None):
    """Strain an `Assembly` until the largest logarithmic strain along an axis with a rate is `strain`, or until `watch`
    says so.

    rates (3,) [1/s] or None; stresses (3,) [Pa], tension positive, or None: each axis has one of both. fastest [1/s]:
    largest rate of a stress-controlled axis. watch(cell): called at each look; the drive ends when it returns True.
    Raises ValueError for an axis with both or neither, and where nothing would ever end the drive.
    """
    if any((rate is None) == (stress is None) for rate, stress in zip(rates, stresses, strict=True)):
        raise ValueError("each axis must have either a rate or a stress")
    driven = [axis for axis in range(3) if rates[axis]]
    if not driven and watch is None:
        raise ValueError("without a rate, watch must say when the drive ends")
    start, usual, stiffness = cell.box.copy(), np.zeros(3), _stiffness(cell)
    while True:
        now = np.diag(cell.stress())
        for axis in range(3):
            if rates[axis] is not None:
                cell.rates[axis] = rates[axis]
            else:
                missing = (stresses[axis] - now[axis]) / stiffness
                asked = GAIN * missing / (EVERY * cell.dt)
                cell.rates[axis] = float(np.clip(usual[axis] + asked, -fastest, fastest))
                usual[axis] = np.clip(usual[axis] + HABIT * asked, -fastest, fastest)
        cell.step(EVERY)
        done = np.abs(np.log(cell.box / start))
        if (driven and done[driven].max() >= strain) or (watch is not None and watch(cell)):
            return


def compress(cell, pressure, fastest=50.0, tolerance=0.01, most=200_000):
    """Bring a cell to an isotropic pressure [Pa]: until each normal stress is within `tolerance` and the motion is less
    than `tolerance` of the elastic energy. fastest: largest rate of an axis [1/s]. Raises ValueError after `most`
    steps."""
    target = np.full(3, -pressure)
    first = cell.steps

    def stands(one):
        if one.steps - first > most:
            raise ValueError(f"{pressure:g} Pa are not reached in {most} steps")
        near = np.abs(np.diag(one.stress()) - target).max() < tolerance * pressure
        return near and one.kinetic_energy() < tolerance * pressure**2 * one.volume / _stiffness(one)

    drive(cell, np.inf, stresses=target, fastest=fastest, watch=stands)
    cell.rates[:] = 0.0


def _stiffness(cell):
    """Stiffness of a contact over the mean diameter [Pa]."""
    return cell.law.stiffness / (2.0 * float(cell.radii.mean()))
