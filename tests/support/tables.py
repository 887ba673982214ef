"""Tables of a scene made by hand, for functions that take one without the rest of it."""

from types import SimpleNamespace

from snowmpm.keys import Keyed


class Table(SimpleNamespace, Keyed):
    """Keys and values."""
