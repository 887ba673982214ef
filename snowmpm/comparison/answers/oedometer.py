"""A sample pressed between smooth walls: the exact path of its law in uniaxial strain, followed with SciPy.

x = -ln(height / height at the start), loading to its largest value and unloading from there; sigma Cauchy stress,
compression positive, along the axis and across.

    elastic             sigma = M x e^x, lambda x e^x
    hypoplastic         d sigma/dx = L(sigma) D + N(sigma) |D|, D = -(1, 0, 0); the ratio tends to K0 = c4 / (3 c1 + c4)
    Cam-Clay (cohesive) dp/dx = K (1 - g y_p), dq/dx = 3 G (2/3 - g y_q), dz/dx = g y_p from first yield on,
                        g = (K y_p + 2 G y_q) / (K y_p^2 + 3 G y_q^2 - y_p0 p0' y_p); elastic on the way back
"""

from functools import cached_property

import numpy as np

from snowmpm.comparison.answers.answer import Answer, History
from snowmpm.comparison.quantity import Quantity
from snowmpm.errors import InputError

FINE = 400
"""Points of the exact curve on the way there, and back."""


def oedometric_path(material, strain, pressure=0.0):
    """Cauchy stresses (n, 2) [Pa], axial and lateral, compression positive, at strains (n,) that grow from 0 and may
    turn back once; material: table of a scene; pressure [Pa]: isotropic at the start. ValueError for a kind of material
    whose path is not known here."""
    path_of = _PATHS.get(material["kind"])
    if path_of is None:
        raise ValueError(f"no exact path of {material['kind']}; there is one of {', '.join(_PATHS)}")
    return path_of(material, np.asarray(strain, float), pressure)


def _elastic(material, strain, pressure):
    bulk, shear = _moduli(material)
    # Kirchhoff stress is linear in the logarithmic strain; the volume is e^-x of the start
    straight = np.stack([(bulk + 4.0 / 3.0 * shear) * strain, (bulk - 2.0 / 3.0 * shear) * strain], axis=1)
    return (straight + pressure) * np.exp(strain)[:, None]


def _hypoplastic(material, strain, pressure):
    from snowmpm.materials import LAWS

    law = LAWS[material["kind"]].model_validate(material)
    apex = law.tensile_apex

    def slope(direction):
        return lambda x, stress: law._rate(law.coefficients, stress - apex, direction * RATE)

    return -_there_and_back(slope(1.0), slope(-1.0), strain, -np.full(3, float(pressure)))[:, :2]


RATE = np.array([-1.0, 0.0, 0.0])


def _cam_clay(material, strain, pressure):
    bulk, shear = _moduli(material)
    slope2, beta, xi = material["critical_slope"] ** 2, material.get("cohesion", 0.0), material["hardening"]

    def y(p, q, p0):
        return q**2 * (1.0 + 2.0 * beta) + slope2 * (p + beta * p0) * (p - p0)

    def plastic(x, state):
        p, q, z = state
        p0, rise = bulk * np.sinh(xi * z), bulk * xi * np.cosh(xi * z)
        y_p, y_q = slope2 * (2.0 * p - (1.0 - beta) * p0), 2.0 * (1.0 + 2.0 * beta) * q
        y_p0 = slope2 * ((beta - 1.0) * p - 2.0 * beta * p0)
        flow = (bulk * y_p + 2.0 * shear * y_q) / (bulk * y_p**2 + 3.0 * shear * y_q**2 - y_p0 * rise * y_p)
        return np.array([bulk * (1.0 - flow * y_p), shear * (2.0 - 3.0 * flow * y_q), flow * y_p])

    def elastic(x, state):
        return np.array([bulk, 2.0 * shear, 0.0])

    start = np.array([pressure, 0.0, np.arcsinh(material["p0"] / bulk) / xi])
    a = 4.0 * shear**2 * (1.0 + 2.0 * beta) + slope2 * bulk**2
    b = slope2 * bulk * (2.0 * pressure - (1.0 - beta) * material["p0"])
    onset = (-b + np.sqrt(b**2 - 4.0 * a * y(pressure, 0.0, material["p0"]))) / (2.0 * a)

    states = _there_and_back(plastic, lambda x, s: -elastic(x, s), strain, start, onset, elastic)
    p, q = states[:, 0], states[:, 1]
    return np.stack([p + 2.0 * q / 3.0, p - q / 3.0], axis=1) * np.exp(strain)[:, None]


def _there_and_back(there, back, strain, start, onset=0.0, before=None):
    """States (n, k) along strains that grow and may turn back; there, back: their slope with |dx|; before: the slope
    before the strain `onset`."""
    from scipy.integrate import solve_ivp

    turn = int(np.argmax(strain))
    states = np.empty((len(strain), len(start)))
    early = strain[: turn + 1] <= onset
    rise = strain[: turn + 1]
    states[: turn + 1][early] = start + rise[early][:, None] * (before(0.0, start) if before else 0.0)
    begin = min(onset, rise[-1])
    state = start + begin * (before(0.0, start) if before else 0.0)

    def path_of(slope, begin, end, at, state):
        if end == begin:
            return np.tile(state, (len(at), 1)), state
        done = solve_ivp(slope, (begin, end), state, method="DOP853", rtol=1e-9, atol=1e-9, dense_output=True)
        return done.sol(at).T, done.y[:, -1]

    states[: turn + 1][~early], state = path_of(there, begin, rise[-1], rise[~early], state)
    states[turn + 1 :], _ = path_of(back, 0.0, rise[-1] - strain[turn + 1 :].min(initial=rise[-1]),
                                    rise[-1] - strain[turn + 1 :], state)
    return states


def _moduli(material):
    young, nu = material["youngs_modulus"], material["poisson_ratio"]
    return young / (3.0 * (1.0 - 2.0 * nu)), young / (2.0 * (1.0 + nu))


_PATHS = {"elastic": _elastic, "hypoplastic": _hypoplastic, "cohesive_cam_clay": _cam_clay,
          "modified_cam_clay": _cam_clay}


class Oedometer(Answer):
    """The first body, a box, under the piston that the reference names; stresses are means over all particles."""

    SOURCE = ("uniaxial strain integrated to 1e-9; K0 of the hypoplastic law: Peng et al. (2015),"
              " doi:10.1007/s11440-015-0399-3, eq. 38")

    def __init__(self, case, reference):
        super().__init__(case, reference)
        case.needs("stress")
        self._piston = case.run.obstacles[reference["piston"]]
        self._initial = case.scene.get("initial", {}).get("pressure", 0.0)

    @cached_property
    def strain(self):
        """x at each frame [-]."""
        shape = self.case.body["shape"]
        height = shape["max"][-1] - shape["min"][-1]
        return -np.log1p(self._piston.translation[:, 2] / height)

    @cached_property
    def stresses(self):
        """Mean stresses (frames, 2) [Pa], axial and lateral in the plane, compression positive."""
        run = self.case.run
        found = (run.frame(i, ["stress"]).fields["stress"].astype(float) for i in range(len(run)))
        return np.array([(-stress[:, 2].mean(), -stress[:, 0].mean()) for stress in found])

    @property
    def piston_stress(self):
        """Mean force of the sample on the piston over its width between the frames (frames - 1,) [Pa]."""
        shape, one = self.case.body["shape"], self._piston
        time = np.concatenate([[0.0], one.time])
        impulse = np.interp(self.case.run.times, time, np.concatenate([[0.0], one.impulse[:, 2]]))
        return np.diff(impulse) / np.diff(self.case.run.times) / (shape["max"][0] - shape["min"][0])

    def _known(self, strain):
        try:
            return oedometric_path(self.case.material, strain, self._initial)
        except ValueError as error:
            raise InputError(f"{self.case.run.path}: {error}") from None

    def quantities(self):
        turn = int(np.argmax(self.strain))
        axial, lateral = self.stresses[turn]
        known = self._known(self.strain[: turn + 1])
        across_time = 0.5 * (known[-2, 0] + known[-1, 0])  # the force is a mean over the last interval
        found = [Quantity.exact("axial stress", "Pa", axial, known[-1, 0]),
                 Quantity.exact("lateral over axial stress", "1", lateral / axial, known[-1, 1] / known[-1, 0]),
                 Quantity.exact("stress on the piston", "Pa", self.piston_stress[turn - 1], across_time)]
        if turn < len(self.strain) - 1:
            known = self._known(self.strain)
            found.append(Quantity.exact("axial stress, unloaded", "Pa", self.stresses[-1, 0], known[-1, 0]))
        return found

    def facts(self):
        if self.case.material["kind"] != "hypoplastic":
            return {}
        from snowmpm.materials import LAWS

        return {"K0": f"{LAWS['hypoplastic'].model_validate(self.case.material).lateral_pressure:.4f}"}

    def history(self):
        turn = int(np.argmax(self.strain))
        fine = np.linspace(0.0, self.strain[turn], FINE)
        if turn < len(self.strain) - 1:
            fine = np.concatenate([fine, np.linspace(self.strain[turn], self.strain[-1], FINE)[1:]])
        return History("strain along the axis  [1]", "axial stress  [Pa]", self.strain, self.stresses[:, 0], fine,
                       self._known(fine)[:, 0])
