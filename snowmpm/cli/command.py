"""A command of the program: a function, whose arguments and options are those of its annotations (typer)."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import typer

from snowmpm.cli.errors import guarded
from snowmpm.cli.help_text import PlainCommand
from snowmpm.registry import COMMANDS, Registry


@dataclass(frozen=True)
class Command:
    """writes: whether it writes files, and has --overwrite; computes: whether it loads plugins, and has --plugin."""

    REGISTRIES: ClassVar[tuple[Registry, ...]] = (COMMANDS,)

    name: str
    function: Callable[..., Any]
    writes: bool = True
    computes: bool = True

    def add_to(self, app: typer.Typer) -> None:
        """Make it a command of an application."""
        app.command(self.name, cls=PlainCommand)(guarded(self.function, self.writes, self.computes))
