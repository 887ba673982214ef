"""`snowmpm study`: measure the program itself."""

from pathlib import Path
from typing import Annotated

import typer

from snowmpm import overwriting
from snowmpm.cli.options import Backend, BackendOption, Threads
from snowmpm.study import STUDIES, open_study

Name = Annotated[str, typer.Argument(metavar="NAME", help=f"One of: {', '.join(STUDIES)}.")]


def study(
    name: Name,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="DIR", help="Output folder; runs/study_NAME by default.")
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="The short form, in minutes.")] = False,
    only: Annotated[
        list[str] | None, typer.Option("--only", metavar="WORD", help="Only this problem or entry; repeatable.")
    ] = None,
    backend: BackendOption = Backend.cpu,
    threads: Threads = 1,
):
    """Measure the program: accuracy against speed, orders of convergence, speed against size, where schemes fail.

    Writes tables (CSV), charts (PNG) and conclusions (Markdown) to DIR. Times are those of one CPU thread unless
    --threads says otherwise.
    """
    from snowmpm.cli.run import start_taichi

    module = open_study(name)
    folder = output or Path("runs") / f"study_{name.replace('-', '_')}"
    overwriting.guard(*folder.glob(f"{name.partition('-')[0]}*.*"))
    start_taichi(backend, threads)
    for path in module.study(folder, quick=quick, only=tuple(only or ()), say=_say):
        print(path)


def _say(line):
    typer.echo(line, err=True)
