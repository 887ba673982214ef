"""An elastic beam released under its weight: the motion of its free end, by the theory of slender beams.

    w(L, t) = sum_n q s_n phi_n(L) / (m omega_n^2) (1 - cos omega_n t),   omega_n = k_n^2 sqrt(EI / m L^4)
    phi_n = cosh k x - cos k x - r (sinh k x - sin k x),   r = (cosh k + cos k) / (sinh k + sin k),   cos k cosh k = -1

with x in lengths L, s_n = int phi_n / int phi_n^2, EI = E/(1 - nu^2) t^3/12 in plane strain, m = rho t and q = m g per
length, g across the beam. Deflections are small beside L; shear and the inertia of rotation, which the theory leaves
out, make a beam of L/t = 10 about 1 % slower.
"""

import numpy as np

from snowmpm.comparison.answers.answer import Answer, History
from snowmpm.comparison.quantity import Quantity
from snowmpm.errors import InputError

ROOTS = (1.8751040687, 4.6940911330, 7.8547574382, 10.9955407349)
"""k_n of the first modes, cos k cosh k = -1; they carry all but 1e-5 of the deflection."""


def end_deflection(time, length, thickness, law, gravity):
    """Deflection of the free end (n,) [m] along gravity at times (n,) [s]; law: density [kg/m3], youngs_modulus [Pa],
    poisson_ratio."""
    stiffness = law["youngs_modulus"] / (1.0 - law["poisson_ratio"] ** 2) * thickness**3 / 12.0
    mass = law["density"] * thickness
    x = np.linspace(0.0, 1.0, 4001)
    total = np.zeros(len(time))
    for k in ROOTS:
        ratio = (np.cosh(k) + np.cos(k)) / (np.sinh(k) + np.sin(k))
        mode = np.cosh(k * x) - np.cos(k * x) - ratio * (np.sinh(k * x) - np.sin(k * x))
        omega = k**2 * np.sqrt(stiffness / (mass * length**4))
        from scipy.integrate import trapezoid  # slow to import

        share = trapezoid(mode, x) / trapezoid(mode**2, x)
        total += gravity * share * mode[-1] / omega**2 * (1.0 - np.cos(omega * np.asarray(time)))
    return total


class Cantilever(Answer):
    """The first body, a level box of elastic material clamped where x is smallest."""

    SOURCE = "Euler-Bernoulli beam in plane strain, sum of modes; e.g. Timoshenko, Vibration Problems in Engineering"

    def __init__(self, case, reference):
        super().__init__(case, reference)
        shape = case.body["shape"]
        if shape["kind"] != "box" or case.material["kind"] != "elastic":
            raise InputError(f"{case.run.path}: what is known of this scene is that of an elastic box, not of a"
                             f" {shape['kind']} of {case.material['kind']}")
        self.length, self.thickness = (high - low for low, high in zip(shape["min"], shape["max"], strict=True))

    def history(self):
        run, case = self.case.run, self.case
        case.needs("id")
        start = run.frame(0, ["id"])
        x = case.positions(start)
        last = np.zeros(len(start), bool)
        last[start.fields["id"].astype(int)] = x[:, 0] > x[:, 0].max() - 0.5 * case.spacing
        height = []
        for i in range(len(run)):
            frame = run.frame(i, ["id"])
            height.append(case.positions(frame)[last[frame.fields["id"].astype(int)], 1].mean())
        fine = np.linspace(0.0, run.times[-1], 400)
        return History("time  [s]", "deflection of the end  [m]", run.times, height[0] - np.array(height), fine,
                       self._known(fine))

    def _known(self, time):
        return end_deflection(time, self.length, self.thickness, self.case.material, -self.case.gravity[-1])

    def quantities(self):
        found = self.history()
        known = np.linspace(0.0, self.case.run.times[-1], 20001)
        return [Quantity.exact(f"{name} of the first swing", unit, measured, exact) for name, unit, measured, exact in
                zip(("depth", "time"), "ms", _first_peak(found.x, found.y), _first_peak(known, self._known(known)),
                    strict=True)]


def _first_peak(time, value):
    """Height and time of the first maximum, by the parabola through it and its neighbours; the end where there is
    none."""
    falls = np.flatnonzero(np.diff(value) < 0.0)
    # Ripples of higher modes and of the start are no swing
    falls = falls[value[falls] > 0.5 * np.max(value)]
    if not len(falls) or falls[0] == 0:
        return value[-1], time[-1]
    i = int(falls[0])
    a, b, c = np.polyfit(time[i - 1 : i + 2] - time[i], value[i - 1 : i + 2], 2)
    shift = -0.5 * b / a
    return c + 0.5 * b * shift, time[i] + shift
