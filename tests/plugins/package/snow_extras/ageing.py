"""A law: elastic snow that knows how old it is."""

from typing import ClassVar, Literal

import numpy as np

import snowmpm
from snowmpm.compiler import ti
from snowmpm.materials import Elastic, StateVariable

elastic_update = Elastic.update


@ti.func
def ageing_update(prm: ti.template(), h, state, A, dt):
    h_new, tau, state_new, dissipation, iterations = elastic_update(prm, h, state, A, dt)
    state_new[0] = state[0] + dt
    return h_new, tau, state_new, dissipation, iterations


@snowmpm.register
class Ageing(Elastic):
    """Elastic snow that knows how old it is."""

    STATE: ClassVar = (StateVariable("age", "s", "time since the start"),)
    OUTPUTS: ClassVar = {"age": "s"}
    RATE_DEPENDENT: ClassVar = True
    kind: Literal["ageing"] = "ageing"
    update = staticmethod(ageing_update)

    def initial_state(self):
        return (0.0,)

    def outputs(self, state):
        return {"age": np.asarray(state)[..., 0]}
