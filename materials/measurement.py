"""What an element test measured: a table, the numbers that matter, and the yield surface it touched."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .arrays import Array
from .law import Law
from .material_point import Path, path_of
from .mixed_control import Reached, stress_free_start
from .symmetric import COMPONENTS, invariants

STEADY_SHARE = 0.1  # last part of a test over which a critical state must hold
ROUND_OFF = 1e-6  # of the largest stress
STEADY = 1e-3  # by how much p and q may change there, relative to themselves
STEADY_VOLUME = 5e-3  # and ln J, relative to the strain
TRIAXIAL = np.diag([1.0, 1.0, -2.0]) / 3.0  # deviator of unit q in axial compression
SECTION_POINTS = 241
SECTION_LIMIT = 4.0  # times the largest stress of the test: how much of an open yield surface is shown


@dataclass(frozen=True)
class Driven:
    """The strain that a test drives: a column of its table, the sign that makes it positive, and its label."""

    column: str
    sign: float
    label: str


@dataclass(frozen=True)
class Characteristics:
    """Numbers of a test; rows count steps, 0 is the start.

    yield_row: first step with plastic flow, None when there is none, and for a rate law, which has no elastic range;
    peak_row: largest q, where it is first reached, None for a test without shear; steady_ratio: q/p of the Cauchy
    stress at the end if the test ends in failure, plastic flow at p and q that stay the same to one part in a thousand
    over its last tenth, else None; critical: whether the volume stays too, to 0.5 % of the strain there.
    """

    yield_row: int | None
    peak_row: int | None
    steady_ratio: float | None
    critical: bool
    drops: bool = False
    """Whether p and q both fall in the step that first yields: a material that collapses bore more before it."""


@dataclass(frozen=True)
class YieldSection:
    """Yield function (n_q, n_p) over p (n_p,), q (n_q,) [Pa, Cauchy] at the start and at the end of a test.

    A law without a yield surface that knows where it fails (`failure_function`) shows that; `name` says which it is.
    The section goes through the direction of the test's own deviator, so that the path lies in it at its end whatever
    the shape of the surface. −inf: never yields.
    """

    name: str
    p: Array
    q: Array
    initial: Array
    final: Array


@dataclass(frozen=True)
class Measurement:
    """A test: its name, law, driven strain, and what was reached at the start and after every step (`Reached`)."""

    name: str
    law: Law
    driven: Driven
    rows: list[Reached]

    @cached_property
    def path(self) -> Path:
        """The test as a `Path`; row 0 is the start."""
        return path_of(self.law, self.rows)

    @cached_property
    def cauchy_invariants(self) -> tuple[Array, Array]:
        """p and q (n,) [Pa] of the Cauchy stress."""
        return invariants(self.path.cauchy)

    @property
    def driven_strain(self) -> Array:
        """(n,), from zero."""
        return self.driven.sign * self.table()[self.driven.column][1]

    def table(self) -> dict[str, tuple[str, NDArray[Any]]]:
        """Column name -> (unit, values (n,)): one row for the start and one a step.

        Strains from the start of the test, Cauchy stress; both positive in tension. p, q: of the Cauchy stress;
        kirchhoff_p, kirchhoff_q: of the Kirchhoff stress, which yield surfaces are written in. prescribed_stress_*: of
        the components whose stress was prescribed; of the others the strain was. plastic_volumetric_strain counts from
        the stress-free state. iterations: of the law; corrections: of the free strains.
        """
        path, rows = self.path, self.rows
        volume = np.log(np.linalg.det(path.deformation))
        columns = {
            "step": ("", np.arange(len(rows))),
            "time": ("s", np.cumsum([row.duration for row in rows])),
            **self._strains(),
            "volumetric_strain": ("-", volume - volume[0]),
        }
        for k, component in enumerate(COMPONENTS):
            columns[f"stress_{component}"] = ("Pa", np.array([row.cauchy[k] for row in rows]))
        p, q = self.cauchy_invariants
        columns |= {"p": ("Pa", p), "q": ("Pa", q), "kirchhoff_p": ("Pa", path.p), "kirchhoff_q": ("Pa", path.q)}
        for name, values in self.law.outputs(path.state).items():
            columns[name] = (self.law.OUTPUTS[name], np.asarray(values))
        for k, variable in enumerate(self.law.STATE):
            columns.setdefault(variable.name, (variable.unit, path.state[:, k]))
        if np.isfinite(path.plastic_volumetric_strain).all():
            columns["plastic_volumetric_strain"] = ("-", path.plastic_volumetric_strain)
        columns["dissipation"] = ("J/m3", path.dissipation)
        columns["iterations"] = ("", path.iterations)
        columns["corrections"] = ("", np.array([row.corrections for row in rows]))
        for k, component in enumerate(COMPONENTS):
            values = np.array([row.prescribed[k] for row in rows])
            if np.isfinite(values).any():
                columns[f"prescribed_stress_{component}"] = ("Pa", values)
        return columns

    def _strains(self) -> dict[str, tuple[str, NDArray[Any]]]:
        strain = np.array([row.strain for row in self.rows])
        if np.isfinite(strain).all():
            return {f"strain_{component}": ("-", strain[:, k]) for k, component in enumerate(COMPONENTS)}
        relative = self.path.deformation @ np.linalg.inv(self.path.deformation[0])
        return {f"F_{'xyz'[i]}{'xyz'[j]}": ("-", relative[:, i, j]) for i in range(3) for j in range(3)}

    def characteristics(self) -> Characteristics:
        """`Characteristics` of the test."""
        p, q = self.cauchy_invariants
        plastic = self.path.iterations > 0
        last = max(2, round(STEADY_SHARE * len(p)))
        sheared = q.max() > ROUND_OFF * np.abs(p).max()
        steady = all(np.ptp(x[-last:]) <= STEADY * abs(x[-1]) for x in (p, q)) and plastic[-last:].all()
        steady = steady and sheared and p[-1] > 0.0
        moved = self.path.deformation[-1] @ np.linalg.inv(self.path.deformation[-last])
        dilates = abs(np.log(np.linalg.det(moved))) > STEADY_VOLUME * np.linalg.norm(moved - np.eye(3))
        first = int(np.argmax(plastic)) if plastic.any() and stress_free_start(self.law) else None
        return Characteristics(
            yield_row=first,
            drops=bool(first and p[first] < p[first - 1] and q[first] <= q[first - 1]),
            peak_row=int(np.argmax(q >= (1.0 - ROUND_OFF) * q.max())) if sheared else None,
            steady_ratio=float(q[-1] / p[-1]) if steady else None,
            critical=bool(steady and not dilates),
        )

    def yield_section(self) -> YieldSection | None:
        """`YieldSection` around the test's path, or None for a law that never yields."""
        p, q = self.cauchy_invariants
        scale = max(np.abs(p).max(), q.max())
        volume = np.linalg.det(self.path.deformation[[0, -1]])
        row = len(q) - 1 if q[-1] > 1e-3 * scale else int(np.argmax(q))
        deviator = self.path.cauchy[row] + p[row] * np.eye(3)
        direction = deviator / q[row] if q[row] > 1e-3 * scale else TRIAXIAL

        fails = self.law.failure_function

        def function(stress, state):
            admissible = self.law.yield_function(stress, state)
            return admissible if fails is None else np.where(admissible > 0.0, 1.0, fails(stress, state))

        def functions(p, q):
            stress = q[..., None, None] * direction - p[..., None, None] * np.eye(3)
            return [function(J * stress, self.path.state[end]) for end, J in zip((0, -1), volume, strict=True)]

        limit = SECTION_LIMIT * scale or 1e9
        if not np.isfinite(functions(np.zeros(1), np.full(1, limit))).any():
            return None
        ladder = np.concatenate([[0.0], limit * np.geomspace(1e-6, 1.0, 121)])
        line = np.concatenate([-ladder[:0:-1], ladder])
        inside = np.any([f <= 0.0 for f in functions(*np.meshgrid(line, ladder))], axis=0)
        low, high = _extent(line, inside.any(axis=0))
        # An open surface reaches the limit; the path then says how much of it is worth showing
        low, high = (1.5 * np.sign(x) * scale if abs(x) == limit else x for x in (low, high))
        top = _extent(ladder, inside[:, (line >= low) & (line <= high)].any(axis=1))[1]
        top = 1.5 * scale if top == limit else top
        p_range = np.array([min(low, p.min()), max(high, p.max())])
        margin = 0.08 * max(np.ptp(p_range), 1e-12)
        grid_p = np.linspace(p_range[0] - margin, p_range[1] + margin, SECTION_POINTS)
        grid_q = np.linspace(0.0, 1.08 * max(top, q.max(), 1e-12), SECTION_POINTS)
        name = "failure surface" if fails else "yield surface"
        return YieldSection(name, grid_p, grid_q, *functions(*np.meshgrid(grid_p, grid_q)))


def _extent(line: Array, inside: NDArray[np.bool_]) -> tuple[float, float]:
    """Where the entries of `line` that are inside begin and end, rounded outward; (0, 0) if there are none."""
    found = np.flatnonzero(inside)
    return (line[max(found[0] - 1, 0)], line[min(found[-1] + 1, len(line) - 1)]) if len(found) else (0.0, 0.0)
