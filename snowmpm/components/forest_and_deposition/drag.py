"""A law of friction with the drag of trees."""

import functools
from collections import namedtuple
from typing import Any

from snowmpm.compiler import ti
from snowmpm.ground.law import FrictionLaw

named: Any = namedtuple
"""Of fields that are known when the program runs only."""


@functools.cache
def with_drag(law: type[FrictionLaw]) -> Any:
    """A law's class whose shear stress has c density v² besides: its PARAMETERS are those of `law` and `forest_drag`, c
    [-].

    c = g/xi adds the turbulent friction of Voellmy's law, xi [m/s2]; it is c_resH of com1DFA, with 0.01 as its default.
    """
    own: Any = law.stress
    fields = law.PARAMETERS._fields

    class WithDrag:
        """What kernels ask of a law of friction."""

        PARAMETERS = named("PARAMETERS", [*fields, "forest_drag"])
        WEAKENS = law.WEAKENS

        @staticmethod
        @ti.func
        def stress(prm: ti.template(), density, sigma, speed, depth):
            """Dry part [Pa] and rate [Pa s/m], see `FrictionLaw`."""
            found = own(prm, density, sigma, speed, depth)
            return ti.Vector([found[0], found[1] + density * prm.forest_drag * speed])

    return WithDrag
