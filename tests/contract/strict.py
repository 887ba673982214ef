"""A method, and its particles, of which nothing is seen but the contract."""

from snowmpm.methods import CONTRACTS
from snowmpm.particles.contract import Particles
from snowmpm.registry import resolved
from snowmpm.stepping.contract import Affine, Forecasts, Method, PushesObstacles

MORE = [*map(resolved, CONTRACTS.values()), Affine, Forecasts, PushesObstacles]
"""What a method may derive from beside the contract."""

SET = {"time"}
"""What the run loop may set."""


def members(contract, kind=object):
    """Public names of an abstract base: what it defines, and what it says that instances have; of a method also those
    of MORE that its class derives from."""
    more = [other for other in MORE if contract is Method and issubclass(kind, other)]
    return {name for one in (contract, *more) for name in [*dir(one), *getattr(one, "__annotations__", {})]
            if not name.startswith("_")}


class Strict:
    """Stands before an object and fails the test that asks it for more than its contract.

    AssertionError, not AttributeError: a default of getattr would hide that.
    """

    def __init__(self, inner, contract, used=None):
        object.__setattr__(self, "_inner", inner)
        object.__setattr__(self, "_contract", contract)
        object.__setattr__(self, "_used", set() if used is None else used)

    @property
    def __class__(self):
        return type(self._inner)

    def __getattr__(self, name):
        known = members(self._contract, type(self._inner))
        assert name in known, f"{name} is not of the contract {self._contract.__name__}"
        self._used.add(f"{self._contract.__name__}.{name}")
        value = getattr(self._inner, name)
        return Strict(value, Particles, self._used) if name == "particles" else value

    def __setattr__(self, name, value):
        assert name in SET, f"nobody may set {name} of a method"
        setattr(self._inner, name, value)


def strict(method, used):
    """The method behind its contract; `used` collects which members were asked for."""
    return Strict(method, Method, used)
