"""Tables whose keys are read by name."""

from typing import Any, ClassVar


class Keyed:
    """A table, `table["key"]` for a key that it has, `table.get("key")` for one that it may not have."""

    EXAMPLES: ClassVar[dict[str, Any]] = {}
    """Values of keys for the page of keys, where no scene of the library and no guide has a good one."""

    def __getitem__(self, key: str) -> Any:
        return getattr(self, key)

    def get(self, key: str, default: Any = None) -> Any:
        """Value of a key; `default` where the table has none of this name."""
        return getattr(self, key, default)


def with_examples(schema: dict[str, Any], model: type[Keyed]) -> None:
    """Put EXAMPLES of a table into its schema (`json_schema_extra` of pydantic)."""
    for key in schema.get("properties", {}).keys() & model.EXAMPLES.keys():
        schema["properties"][key]["examples"] = [model.EXAMPLES[key]]
