"""Tables whose keys are read by name, and what their source says of the keys."""

import ast
import functools
import inspect
import itertools
import sys
from collections.abc import Iterator
from typing import Any, ClassVar

from pydantic import ConfigDict


class Keyed:
    """A table, `table["key"]` for a key that it has, `table.get("key")` for one that it may not have."""

    EXAMPLES: ClassVar[dict[str, Any]] = {}
    """Values of keys for the page of keys, where no scene of the library and no guide has a good one."""
    EXTENDED: ClassVar[tuple[type, ...]] = ()
    """Tables of components whose keys it has besides (`components.extend`)."""

    def __getitem__(self, key: str) -> Any:
        return getattr(self, key)

    def get(self, key: str, default: Any = None) -> Any:
        """Value of a key; `default` where the table has none of this name."""
        return getattr(self, key, default)


def with_words(schema: dict[str, Any], model: type[Any]) -> None:
    """Put docstrings and EXAMPLES of the keys of a table into its schema (`json_schema_extra` of pydantic)."""
    properties = schema.get("properties", {})
    for name, words in docstrings(model).items():
        if name in model.model_fields:
            properties.get(model.model_fields[name].alias or name, {}).setdefault("description", words)
    for key in properties.keys() & model.EXAMPLES.keys():
        properties[key]["examples"] = [model.EXAMPLES[key]]


def docstrings(model: type[Any]) -> dict[str, str]:
    """Docstrings of the fields of a table, those of the classes that it derives from and of its extensions included.

    Read when they are asked for: pydantic's `use_attribute_docstrings` reads the source of every table at each start,
    0.4 s of a command (measured).
    """
    return {name: words for base in (*reversed(model.__mro__), *model.EXTENDED)
            for name, words in _in_source(base.__module__).get(base.__qualname__, {}).items()}


@functools.cache
def _in_source(module: str) -> dict[str, dict[str, str]]:
    """{class: {field: docstring}} of a module; nothing of one without a file."""
    try:
        tree = ast.parse(inspect.getsource(sys.modules[module]))
    except (KeyError, OSError, TypeError):
        return {}
    found: dict[str, dict[str, str]] = {}
    pending: list[tuple[ast.AST, str]] = [(tree, "")]
    while pending:
        node, around = pending.pop()
        for one in ast.iter_child_nodes(node):
            if isinstance(one, ast.ClassDef):
                found[around + one.name] = dict(_documented(one.body))
                pending.append((one, f"{around}{one.name}."))
            else:
                made_in = f"{around}{one.name}.<locals>." if isinstance(one, ast.FunctionDef) else around
                pending.append((one, made_in))
    return found


def _documented(body: list[ast.stmt]) -> Iterator[tuple[str, str]]:
    """(name, docstring) of each field that has one."""
    for field, words in itertools.pairwise(body):
        if (isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name) and isinstance(words, ast.Expr)
                and isinstance(words.value, ast.Constant) and isinstance(words.value.value, str)):
            yield field.target.id, inspect.cleandoc(words.value.value)


TABLE_CONFIG = ConfigDict(frozen=True, extra="forbid", defer_build=True, json_schema_extra=with_words)
"""Of tables of scenes and of laws. What checks a table is built when the first one is read: the table of a scene holds
that of all within it, which need none of their own."""
