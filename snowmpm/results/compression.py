"""Confined compression of a sample by a piston: stress against strain, and its four stages.

Snow as a microstructure of ice and voids is first elastic, then softens as bonds break, then collapses at an almost
constant stress, and finally densifies as its pores close (Gaume et al., "Modeling snow and avalanches with the Material
Point Method and finite strain elastoplasticity", section 5.1).
"""

from dataclasses import dataclass

import numpy as np

BINS = 200
"""Number of intervals of strain over which the stress is averaged."""

DROP = 0.2
"""Relative drop of the stress after a maximum that makes it the peak; ripples drop less."""

ELASTIC = (0.2, 0.7)
"""Range of stress, as shares of the peak stress, from which the modulus is fitted."""


@dataclass(frozen=True)
class StressStrain:
    """strain (n,): -(H - H0) / H0, positive in compression; stress (n,) [Pa]: of the piston on the sample over the area
    at the start, mean over the interval of strain that ends there."""

    strain: np.ndarray
    stress: np.ndarray

    @classmethod
    def of_piston(cls, time, impulse, displacement, height, area, bins=BINS):
        """From the record of a piston.

        time (n,) [s]; impulse (n,) [N s] of the sample on it, against its motion; displacement (n,) [m], increasing;
        height H0 [m] and area [m2] of the sample ([m] in 2-D, where impulses are per metre). The mean stress of an
        interval is exact: the impulse gained over its time.
        """
        moving = np.concatenate([[True], np.diff(displacement) > 0.0])
        time, impulse, strain = time[moving], impulse[moving], displacement[moving] / height
        ends = np.linspace(strain[0], strain[-1], bins + 1)
        at = np.interp(ends, strain, time)
        return cls(ends[1:], np.diff(np.interp(at, time, impulse)) / np.diff(at) / area)


@dataclass(frozen=True)
class Stages:
    """The four stages of a curve.

    modulus [Pa] of the rise; peak_strain, peak_stress [Pa] where bonds begin to break; softened [Pa]: least stress
    between the peak and densification; plateau [Pa]: mean stress of the collapse, from peak to densification;
    densification: strain at its onset; hardening [Pa]: mean slope from there to the end; end_stress [Pa].
    """

    modulus: float
    peak_strain: float
    peak_stress: float
    softened: float
    plateau: float
    densification: float
    hardening: float
    end_stress: float


def stages(curve):
    """`Stages` of a `StressStrain`, or None if it does not have all of them.

    Onset of densification: where the efficiency of energy absorption, the work so far over the stress, is largest, as
    for foams (Li, Magkiriadis & Harrigan (2006), Journal of Cellular Plastics 42, 371-392).
    """
    strain, stress = curve.strain, curve.stress
    highest = np.maximum.accumulate(stress)
    fallen = np.flatnonzero((stress < (1.0 - DROP) * highest) & (highest > 0.0))
    if not len(fallen):
        return None
    peak = int(stress[: fallen[0]].argmax())
    onset = _onset(strain, stress, peak)
    if onset <= peak + 1 or onset >= len(strain) - 1:
        return None
    rise = slice(*np.searchsorted(highest[: peak + 1], np.array(ELASTIC) * stress[peak]) + np.array([0, 1]))
    return Stages(
        modulus=_slope(strain[rise], stress[rise]), peak_strain=float(strain[peak]), peak_stress=float(stress[peak]),
        softened=float(stress[peak:onset].min()), plateau=float(stress[peak:onset].mean()),
        densification=float(strain[onset]), end_stress=float(stress[-1]),
        hardening=float((stress[-1] - stress[onset]) / (strain[-1] - strain[onset])))


def _onset(strain, stress, peak):
    """Index after the peak at which work over stress is largest."""
    work = np.cumsum(stress * np.diff(strain, prepend=0.0))
    efficiency = work / np.maximum(_smooth(stress), 1e-3 * stress[peak])
    return peak + int(efficiency[peak:].argmax())


def _smooth(stress, width=9):
    """Running mean, so that a single low value does not count as the onset."""
    padded = np.pad(stress, width // 2, mode="edge")
    return np.convolve(padded, np.full(width, 1.0 / width), mode="valid")


def _slope(strain, stress):
    if len(strain) < 2:
        return float(stress[-1] / strain[-1])
    return float(np.polyfit(strain, stress, 1)[0])
