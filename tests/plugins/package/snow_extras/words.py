"""A command: how fast the snow of a run was."""

from typing import Annotated

import typer

import snowmpm
from snowmpm.cli.command import Command


def fastest(run: Annotated[str, typer.Argument(help="Folder of a run.")]):
    """Print the largest speed of a run."""
    print(f"{max(snowmpm.open_run(run).history['max_speed']):.3f} m/s")


snowmpm.register(Command("fastest", fastest, writes=False, computes=False))
