"""An event: a body gets a velocity at once."""

from typing import ClassVar, Literal

import numpy as np

import snowmpm
from snowmpm.running.event import Event as Acting
from snowmpm.scenes.events import Event
from snowmpm.scenes.space import Vector
from snowmpm.scenes.spec import NonNegative


class Kicking(Acting):
    """Adds to the velocity of a body, once its time has come."""

    def apply(self, simulation):
        if simulation.time >= self._spec.start:
            fields = simulation.particles
            mass = float(fields["mass"][fields["body"] == self._body].sum())
            simulation.solver.push(simulation.numbers_of_body(self._body), np.array(self._spec.gain), mass)
            self.done = True


@snowmpm.register
class Kick(Event):
    """A body gets a velocity at once."""

    NEEDS: ClassVar = "loads"
    ACTS: ClassVar = Kicking
    kind: Literal["kick"] = "kick"
    body: str
    """name of the body"""
    start: NonNegative = 0.0
    """[s]"""
    gain: Vector
    """what is added to its velocity [m/s]"""
