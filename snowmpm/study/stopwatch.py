"""Time of a solver's steps, without compilation, set-up and the study's own reads."""

import time
from dataclasses import dataclass, field

import numpy as np

WARM_UP = 3
"""First steps of a solver, in which kernels are compiled or loaded: they count as the others."""


@dataclass
class Stopwatch:
    """Seconds of every step of the solvers that it follows, and their particle-steps.

    Processor time of all threads: on one thread it is the time that the machine needs when nothing else runs, and it
    hardly changes when something does.
    """

    runs: list = field(default_factory=list)
    """Seconds of each step of each solver that was followed."""
    particle_steps: int = 0
    particles: int = 0

    def time_steps_of(self, solver):
        """Time every step of `solver` from now on; -> the solver."""
        seconds, step = [], solver.step

        def timed(dt):
            start = time.process_time()
            step(dt)
            seconds.append(time.process_time() - start)
            self.particle_steps += solver.particles.count

        solver.step = timed
        self.runs.append(seconds)
        self.particles = max(self.particles, solver.particles.count)
        return solver

    @property
    def steps(self):
        return sum(len(run) for run in self.runs)

    @property
    def seconds(self):
        """Processor seconds of all steps, each taken for the median one of its solver: what else runs on the machine
        then weighs less. A sort, every few steps to every few hundred, is left out where it is rare."""
        return float(sum(len(run) * np.median(run[WARM_UP:] or run) for run in self.runs if run))
