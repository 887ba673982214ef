"""`snowmpm report`: a run as one page."""

from pathlib import Path
from typing import Annotated

import typer

from snowmpm import overwriting
from snowmpm.cli.options import Quiet, RunPath

Output = Annotated[
    Path | None,
    typer.Option("-o", "--output", metavar="FILE", help="An .html or .pdf file; RUN/report.html by default."),
]


def report(
    run: RunPath,
    output: Output = None,
    still: Annotated[
        bool, typer.Option("--still", help="Without the interactive 3-D scene: a smaller file.")
    ] = False,
    quiet: Quiet = False,
):
    """Write one page about a run: settings, pictures, curves, maps, audit, warnings, how to reproduce it.

    The page is self-contained: it opens in any browser, and can be sent and kept. With -o FILE.pdf the same content is
    written as PDF.
    """
    from snowmpm.io import Run
    from snowmpm.render import render_report

    opened = Run(run)
    target = output or opened.path.with_name("report.html")
    overwriting.guard(target)
    written = render_report(opened, target, interactive=not still)
    if not quiet:
        print(written)
