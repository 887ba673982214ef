"""What can go wrong, in the words a user reads."""


class InputError(Exception):
    """Bad input: one or two lines naming file, key, value and what is allowed. The command line exits with 2."""

    @classmethod
    def at(cls, key, value, allowed, file=None):
        """`file: key = value: allowed`, the one form of every message about a scene key."""
        where = f"{file}: " if file else ""
        return cls(f"{where}{key} = {value!r}: {allowed}")


class SimulationError(Exception):
    """A simulation that cannot go on: which particle, when and why. The command line exits with 1."""


class WriteError(SimulationError):
    """A run that cannot write what it has to (disk full, folder gone): where, why, and what is safe."""
