"""A method, and its particles, of which nothing is seen but the contract."""

from snowmpm.particles.contract import Particles
from snowmpm.stepping.contract import Method

SET = {"time"}
"""What the run loop may set."""


def members(contract):
    """Public names of an abstract base: what it defines, and what it says that instances have."""
    return {name for name in [*dir(contract), *contract.__annotations__] if not name.startswith("_")}


class Strict:
    """Stands before an object and fails the test that asks it for more than its contract.

    AssertionError, not AttributeError: a default of getattr would hide that.
    """

    def __init__(self, inner, contract, used=None):
        object.__setattr__(self, "_inner", inner)
        object.__setattr__(self, "_contract", contract)
        object.__setattr__(self, "_used", set() if used is None else used)

    def __getattr__(self, name):
        assert name in members(self._contract), f"{name} is not of the contract {self._contract.__name__}"
        self._used.add(f"{self._contract.__name__}.{name}")
        value = getattr(self._inner, name)
        return Strict(value, Particles, self._used) if name == "particles" else value

    def __setattr__(self, name, value):
        assert name in SET, f"nobody may set {name} of a method"
        setattr(self._inner, name, value)


def strict(method, used):
    """The method behind its contract; `used` collects which members were asked for."""
    return Strict(method, Method, used)
