"""A component: drag of the air, in each of whose steps particles slow towards the wind.

    dv/dt = -k |v - u| (v - u),   v' - u = (v - u) / (1 + dt k |v - u|)
"""

import numpy as np

import snowmpm
from snowmpm.components.contract import Component
from snowmpm.particles.fields import ParticleField
from snowmpm.scenes.space import Vector
from snowmpm.scenes.spec import NonNegative, Spec
from snowmpm.stepping.component import Adapter


class Air(Spec):
    """The table `[air]`."""

    drag: NonNegative
    """k [1/m]"""
    wind: Vector
    """u [m/s]"""


class OfScene(Spec):
    """Keys of a scene."""

    air: Air | None = None
    """drag of the air; none when missing"""


class AirDrag(Adapter):
    """Drag of the air on all particles; their column "blown" is the speed that it took of each so far [m/s]."""

    name = "air_drag"

    def __init__(self, model):
        self._k, self._wind = model.scene.air.drag, np.array(model.scene.air.wind)
        self.columns = {"blown": 1}
        self.restart()

    def begin(self, solver):
        self._solver = solver

    def restart(self):
        self._work = 0.0

    def before_step(self, dt, pushed):
        solver, store = self._solver, self._solver.particles
        table = store.table()
        at, blown = store.layout.columns("velocity"), store.layout.columns("blown")
        before = table[:, at].astype(float)
        slip = before - self._wind
        after = self._wind + slip / (1.0 + dt * self._k * np.linalg.norm(slip, axis=1))[:, None]
        mass = store.masses()
        solver.add_impulse(mass @ (after - before))
        self._work += 0.5 * float(mass @ ((after**2).sum(axis=1) - (before**2).sum(axis=1)))
        table[:, at], table[:, blown] = after, table[:, blown] + np.linalg.norm(after - before, axis=1)[:, None]
        store.overwrite(table)
        return pushed

    def force_work(self):
        return self._work

    def work(self):
        return {"particle": self._solver.particles.count, "step": 1}

    def row(self):
        return {"air_work": self._work}

    def units(self):
        return {"air_work": "J"}

    def state(self):
        return {"work": self._work}

    def restore(self, state):
        self._work = state["work"]


def asked(scene):
    if scene.air is not None:
        yield "air.drag", scene.air.drag


def blown(fields):
    return fields.column("blown")[:, 0] if "blown" in fields.sizes else np.zeros(len(fields["id"]))


snowmpm.register(Component("air_drag", "", "drag of the air", asked, order=200, keys={"scene": OfScene},
                           adapters={"mpm": AirDrag}, costs={"particle": 60.0, "step": 1e5}))
snowmpm.register(ParticleField("blown", "m/s", blown))
