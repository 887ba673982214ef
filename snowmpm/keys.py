"""Tables whose keys are read by name."""

from typing import Any


class Keyed:
    """A table, `table["key"]` for a key that it has, `table.get("key")` for one that it may not have."""

    def __getitem__(self, key: str) -> Any:
        return getattr(self, key)

    def get(self, key: str, default: Any = None) -> Any:
        """Value of a key; `default` where the table has none of this name."""
        return getattr(self, key, default)
