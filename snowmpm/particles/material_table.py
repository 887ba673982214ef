"""The laws of a scene as the tables that kernels read."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from snowmpm.compiler import ti
from snowmpm.compiler.runtime import DTYPES

AT_ONCE = 100_000
"""Particles whose wave speeds are computed at once."""

DENSITY = 0
"""Column of the table of numbers that holds the reference density; a law's own parameters follow it."""

BREAKING_RATE = 1e-3
"""Share of `Law.bond_energy` that the plastic work of a step must reach for bonds to count as breaking: what creeps at
its yield stress, or yields by round-off, keeps its bonds for longer than a crack takes to pass."""


class LawFunctions(NamedTuple):
    """What a kernel is compiled for: the Taichi functions of a `Law`, None for what it lacks, the names of its numbers,
    and its BONDS, None without bonds that break."""

    update: Callable
    vector_update: Callable | None
    stiffness: Callable | None
    names: type
    bonds: int | None

    @classmethod
    def of(cls, law):
        """Those of a law."""
        bonds = law.BONDS if law.bonds_last_below > 0.0 else None
        return cls(law.update, law.vector_update, law.stiffness, type(law.parameters()), bonds)


class MaterialTable:
    """Numbers of every material of a scene; kernels are compiled for `functions`, never for the numbers.

    numbers[m]: density, the law's own parameters, `Law.bonds_last_below` and the plastic work of a step [J/m3] from
    which on bonds count as breaking; law_of[m]: index into `functions`, the `LawFunctions` of the scene.
    """

    def __init__(self, laws, precision):
        self.laws = tuple(laws)
        # Laws that share functions count as one, so that they are compiled once; in an order of names, not of the scene
        functions_of = [LawFunctions.of(law) for law in self.laws]
        names = [(law.kind, law.model_dump_json()) for law in self.laws]
        first_name = dict(zip(reversed(functions_of), reversed(names), strict=True))
        self.functions = tuple(sorted(first_name, key=lambda functions: first_name[functions]))
        self.density = np.array([law.density for law in laws])
        self.wave_speed = max(law.wave_speed() for law in laws)
        """of the stiffest material, elastic [m/s]"""
        self.fastest_wave = max(law.fastest_wave() for law in laws)
        """what a step must follow, where yielding makes a material stiffer too [m/s]"""
        self.state_size = max([1, *(len(law.STATE) for law in laws)])
        self.initial_state = np.zeros((len(laws), self.state_size))
        numbers = np.zeros((len(laws), 3 + max(len(law.parameters()) for law in laws)), DTYPES[precision][1])
        for m, law in enumerate(laws):
            state, parameters = law.initial_state(), law.parameters()
            self.initial_state[m, : len(state)] = state
            row = law.density, *parameters, law.bonds_last_below, BREAKING_RATE * law.bond_energy
            numbers[m, : len(row)] = row
        self.numbers = ti.ndarray(DTYPES[precision][0], numbers.shape)
        self.numbers.from_numpy(numbers)
        law_of = np.array([self.functions.index(functions) for functions in functions_of], np.int32)
        self.law_of = ti.ndarray(ti.i32, law_of.shape)
        self.law_of.from_numpy(law_of)

    def n_bonded(self, material):
        """How many particles have bonds that break; material (n,): index of each."""
        bonded = [law.bonds_last_below > 0.0 for law in self.laws]
        return int(np.array(bonded)[material].sum())

    def first_extremes(self, population):
        """(largest |be - I|, largest wave speed [m/s]) of a `Population`, as the report of a step has them: laws that
        stiffen tell the speed of their state, of the others counts the strain that they store."""
        deviation, speed = 0.0, 0.0
        for m, law in enumerate(self.laws):
            own = np.flatnonzero(population.material == m)
            if law.stiffness is None:
                deviation = max(deviation, np.linalg.norm(population.elastic[own], axis=1).max(initial=0.0))
                continue
            for begin in range(0, len(own), AT_ONCE):
                some = own[begin : begin + AT_ONCE]
                stress, state = population.stress[some], self.state_of(population, some)[:, : len(law.STATE)]
                stress = np.pad(stress, ((0, 0), (0, 6 - stress.shape[1])))
                speed = max(speed, law.wave_speed_at(stress, state).max())
        return float(deviation), float(speed)

    def state_of(self, population, rows):
        """State of the laws (n, state_size) that these particles of a `Population` start with."""
        state = self.initial_state[population.material[rows]]
        if population.state is not None:
            given = population.state[rows, : state.shape[1]]
            state[:, : given.shape[1]] = np.where(np.isnan(given), state[:, : given.shape[1]], given)
        return state

    def elastic_energy(self, material, stress, state, volume):
        """Recoverable energy [J] of particles: material (n,), Kirchhoff stress (n, 4) or (n, 6) [Pa], state of the laws
        (n, state_size), reference volume (n,) [m3]. NumPy."""
        stress, energy = np.pad(stress, ((0, 0), (0, 6 - stress.shape[1]))), 0.0
        for m, law in enumerate(self.laws):
            own = material == m
            energy += float((volume[own] * law.elastic_energy(stress[own], state[own])).sum())
        return energy
