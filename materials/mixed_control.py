"""Mixed control of a material point, as in a testing machine: some strains are prescribed, of the others the stress.

Of each pair (strain, stress; see `loading_stage.py`) one is given. The unknown strains of a step solve

    R(ε_free) = σ_prescribed(ε) − σ_target = 0

by Newton's method. The tangent comes from differences, its k perturbed states updated in one batch, and so are the
fractions of a correction among which a line search chooses. It needs nothing of a law but `update`, so it serves
strain-driven and rate laws alike.

A material that softens may not bear the prescribed stress anywhere near: a weak layer under its slab. As in a machine
that holds its load it then gives way until it bears it again: the nearest of `JUMPS` from which Newton's method gets
there. What it gives way through is not followed; its dissipation is that of one step of the law.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from .arrays import Array, Precision
from .law import Law
from .loading_stage import LoadingError, LoadingStage, deformation_of
from .stress_update import StressUpdate
from .symmetric import COMPONENTS, pack

PERTURBATION = {"f32": 3e-5, "f64": 1e-7}  # of a strain, for differences: square root of its rounding, about
RELATIVE = {"f32": 1e-5, "f64": 1e-11}  # accuracy of a prescribed stress, of the largest stress there is
ROUNDING = {"f32": 1e-8, "f64": 1e-15}  # of an elastic strain; times the stiffness of P-waves, of a stress
MAX_CORRECTIONS = 30
MAX_HALVINGS = 6  # of a step that does not converge: 64 parts
LONGEST = 0.2  # strain of one correction: far from the solution a tangent may point anywhere
FRACTIONS = 0.5 ** np.arange(11)  # of a correction, to choose from
JUMPS = 1e-3 * 2.0 ** np.arange(10)  # of the free strains, where a material that softens drops its load


@dataclass(frozen=True)
class Reached:
    """Where a material point is after a step.

    strain (6,) from `origin`, the F (3, 3) at the start of the test (NaN along a prescribed F); deformation F (3, 3);
    h (6,); kirchhoff (6,) [Pa]; state; of the step: prescribed Cauchy stress (6,) [Pa], NaN where the strain was
    prescribed; time it took [s]; dissipation [J/m³]; the law's iterations; corrections of the free strains.
    """

    strain: Array
    origin: Array
    deformation: Array
    h: Array
    kirchhoff: Array
    state: Array
    prescribed: Array
    duration: float = 0.0
    dissipation: float = 0.0
    iterations: int = 0
    corrections: int = 0

    @property
    def cauchy(self) -> Array:
        """σ = τ / det F, (6,) [Pa]."""
        return self.kirchhoff.astype(float) / np.linalg.det(self.deformation)


def stress_free_start(law: Law) -> bool:
    """Whether a law has a stress-free elastic state to start from; a rate law has not."""
    return bool(np.isfinite(law.hencky_from_stress(-np.eye(3))).all())


class MixedControl:
    """A material point in a testing machine: `MixedControl(law).follow_stages(stages)`. precision "f32" or "f64"."""

    law: Law
    precision: Precision

    def __init__(self, law: Law, precision: Precision = "f64") -> None:
        self.law, self.precision = law, precision
        self._update = StressUpdate(law, 3, precision)
        self._resolution = ROUNDING[precision] * law.density * law.wave_speed() ** 2  # [Pa]

    def at_stress(self, stress: ArrayLike | None = None) -> Reached:
        """Point with the law's initial state at a Kirchhoff stress (3, 3) [Pa], zero by default; F = I there."""
        stress = np.zeros((3, 3)) if stress is None else np.asarray(stress, float)
        h, state = pack(self.law.h_from_stress(stress))[None], self._update.initial_state(1)
        there = self._update(h, state, np.zeros((1, 3, 3)))
        return Reached(
            np.zeros(6), np.eye(3), np.eye(3), there.h[0], there.stress[0], there.state[0], np.full(6, np.nan)
        )

    def consolidated(self, pressure: float) -> Reached:
        """Point under an isotropic Cauchy pressure [Pa], compressed from its stress-free state; strains start here.

        A rate law starts at the pressure, with its initial state. Raises LoadingError for a pressure out of reach.
        """
        if not stress_free_start(self.law):
            if not pressure > 0.0:
                raise LoadingError("this law starts from a state under stress: the pressure must be > 0")
            return self.at_stress(-pressure * np.eye(3))
        point = self.at_stress()
        if pressure == 0.0:
            return point
        try:
            point = self.follow_stages([LoadingStage(stress=dict.fromkeys(("xx", "yy", "zz"), -pressure), steps=10)],
                                       point)[-1]
        except LoadingError as error:
            raise LoadingError(f"the pressure of {pressure:g} Pa cannot be applied: {error}") from None
        return Reached(
            np.zeros(6), point.deformation, point.deformation, point.h, point.kirchhoff, point.state, np.full(6, np.nan)
        )

    def follow_stages(self, stages: Iterable[LoadingStage], start: Reached | None = None) -> list[Reached]:
        """List of `Reached`, one a step of every stage, from `start` (the stress-free state by default).

        Raises LoadingError, which names the step, where a prescribed stress cannot be reached or the law fails.
        """
        point = self.at_stress() if start is None else start
        rows: list[Reached] = []
        change = np.zeros(6)
        for stage in stages:
            first_strain, first_stress = point.strain, point.cauchy
            strain, stress = stage.targets(point.strain)
            for i in range(1, stage.steps + 1):
                share = i / stage.steps
                # The end of the stage is met as given, not as a sum
                target = (
                    strain if i == stage.steps else first_strain + share * (strain - first_strain),
                    stress if i == stage.steps else first_stress + share * (stress - first_stress),
                )
                reached = self._reach(point, target, stage.duration / stage.steps, change, len(rows) + 1)
                change, point = reached.strain - point.strain, reached
                rows.append(point)
        return rows

    def follow_deformation(self, F: Array, durations: Array, start: Reached | None = None) -> list[Reached]:
        """List of `Reached`, one for each F (n, 3, 3), counted from the F of `start`, in steps of `durations` (n,) [s].

        Raises LoadingError where the law fails.
        """
        point = self.at_stress() if start is None else start
        rows = []
        for step, (target, duration) in enumerate(zip(F @ point.deformation, durations, strict=True), start=1):
            increment = (target - point.deformation) @ np.linalg.inv(point.deformation)
            updated = self._update(point.h[None], point.state[None], increment[None], duration)
            if updated.iterations[0] < 0:
                raise LoadingError(f"step {step}: the stress update failed; smaller steps may help", step)
            there = replace(point, strain=np.full(6, np.nan), prescribed=np.full(6, np.nan), duration=duration)
            point = _updated(there, target, updated, 0)
            rows.append(point)
        return rows

    def _reach(self, point, target, dt, change, step, halvings=0):
        """One step, in halves where Newton's method fails; `change` of strain in the step before is the first guess."""
        for guess in (change, np.zeros(6)):
            reached = self._newton(point, target, dt, guess)
            if reached is not None:
                return reached
        if halvings == MAX_HALVINGS:
            reached = self._jump(point, target, dt)
            if reached is not None:
                return reached
            raise LoadingError(_failure(point, target, step), step)
        strain, stress = target
        middle = point.strain + 0.5 * (strain - point.strain), point.cauchy + 0.5 * (stress - point.cauchy)
        first = self._reach(point, middle, 0.5 * dt, 0.5 * change, step, halvings + 1)
        second = self._reach(first, target, 0.5 * dt, first.strain - point.strain, step, halvings + 1)
        return replace(
            second,
            duration=dt,
            dissipation=first.dissipation + second.dissipation,
            iterations=max(first.iterations, second.iterations),
            corrections=first.corrections + second.corrections,
        )

    def _jump(self, point, target, dt):
        """One step to where the prescribed stress is borne again, or None; of a test that a strain drives: what a load
        alone crushes is refused."""
        strain, stress = target
        free = np.flatnonzero(np.isfinite(stress))
        if not (strain != point.strain)[np.isfinite(strain)].any():
            return None
        _, cauchy = self._evaluate(point, np.where(np.isfinite(strain), strain, point.strain)[None], dt)
        if not len(free) or np.isnan(cauchy).any():
            return None
        change = np.zeros(6)
        for size in JUMPS:
            change[free] = size * np.sign(stress[free] - cauchy[0, free])
            reached = self._newton(point, target, dt, change, near=False)
            if reached is not None:
                return reached
        return None

    def _newton(self, point, target, dt, change, near=True):
        """One step in one piece, or None; near: it may also begin at no change at all of the free strains."""
        strain, stress = target
        free = np.flatnonzero(np.isfinite(stress))
        wanted = stress[free]
        # First guess: as in the step before, or no change at all where that is nearer, as where the loading turns round
        guesses = np.tile(np.where(np.isfinite(strain), strain, point.strain), (2, 1))
        guesses[0, free] += change[free]
        trials = guesses if near and len(free) else guesses[:1]
        before = np.inf
        for corrections in range(MAX_CORRECTIONS + 1):
            updated, cauchy = self._evaluate(point, trials, dt)
            misfit = np.linalg.norm(cauchy[:, free] - wanted, axis=1)
            misfit[np.isnan(cauchy).any(axis=1)] = np.inf
            # Newton's correction, as long as it halves the misfit; then the best fraction of it
            best = 0 if corrections and misfit[0] < 0.5 * before else np.argmin(misfit)
            if not misfit[best] < before:
                return None
            before, residual = misfit[best], cauchy[best, free] - wanted
            if np.abs(residual).max(initial=0.0) <= self._tolerance(cauchy[best], wanted):
                there = replace(point, strain=trials[best], prescribed=stress, duration=dt, corrections=corrections)
                return _updated(there, deformation_of(trials[best]) @ point.origin, updated, best)
            tangent = self._tangent(point, trials[best], cauchy[best], free, residual, dt)
            if tangent is None:
                return None
            correction = -np.linalg.lstsq(tangent, residual, rcond=1e-12)[0]
            correction *= min(1.0, LONGEST / max(np.abs(correction).max(), 1e-300))
            trials = np.tile(trials[best], (len(FRACTIONS), 1))
            trials[:, free] += FRACTIONS[:, None] * correction
        return None

    def _tangent(self, point, strain, cauchy, free, residual, dt):
        """∂σ/∂ε (k, k) of the free components by differences, or None where the law fails.

        Each strain is perturbed to the side where it is expected to go: at the tip of a yield surface the material is
        stiff to one side and gives way to the other.
        """
        size = np.where(residual > 0.0, -1.0, 1.0) * PERTURBATION[self.precision]
        neighbours = np.tile(strain, (len(free), 1))
        neighbours[np.arange(len(free)), free] += size
        near = self._evaluate(point, neighbours, dt)[1][:, free]
        return None if np.isnan(near).any() else ((near - cauchy[free]) / size[:, None]).T

    def _evaluate(self, point, strains, dt):
        """Updates to strains (m, 6) and their Cauchy stresses (m, 6), NaN where the law failed."""
        F = deformation_of(strains) @ point.origin
        increments = (F - point.deformation) @ np.linalg.inv(point.deformation)
        m = len(strains)
        updated = self._update(np.tile(point.h, (m, 1)), np.tile(point.state, (m, 1)), increments, dt)
        cauchy = updated.stress.astype(float) / np.linalg.det(F)[:, None]
        cauchy[(updated.iterations < 0) | ~np.isfinite(cauchy).all(axis=1)] = np.nan
        return updated, cauchy

    def _tolerance(self, cauchy, wanted):
        largest = max(np.abs(cauchy).max(), np.abs(wanted).max(initial=0.0))
        return RELATIVE[self.precision] * largest + self._resolution


def _updated(point, F, updated, row):
    return replace(
        point,
        deformation=F,
        h=updated.h[row],
        kirchhoff=updated.stress[row],
        state=updated.state[row],
        dissipation=float(updated.dissipation[row]),
        iterations=int(updated.iterations[row]),
    )


def _failure(point, target, step):
    stress = target[1]
    if not np.isfinite(stress).any():
        return f"step {step}: the stress update failed; smaller steps may help"
    wanted = [f"{c} = {stress[k]:.6g} Pa" for k, c in enumerate(COMPONENTS) if np.isfinite(stress[k])]
    nearest = [f"{c} = {point.cauchy[k]:.6g} Pa" for k, c in enumerate(COMPONENTS) if np.isfinite(stress[k])]
    return f"step {step}: stress {', '.join(wanted)} cannot be reached; the last before it is {', '.join(nearest)}"
