"""`snowmpm release`: what a slab run has released, as the release of a flow."""

from pathlib import Path
from typing import Annotated

import typer

from snowmpm import overwriting
from snowmpm.cli.options import Quiet, RunPath


def release(
    run: RunPath,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="DIR", help="Folder; that of the run by default.")
    ] = None,
    quiet: Quiet = False,
):
    """Write the area and thickness of the snow that a run in 3-D has released: release.gpkg and release.tif.

    A depth-averaged scene takes either as its release: region = { file = "release.gpkg" } with top = "file", or
    top = { file = "release.tif" }.
    """
    from snowmpm.io import Run
    from snowmpm.pit.released import released_by, write

    opened = Run(run)
    folder = output or opened.path.parent
    overwriting.guard_in(folder, ("release.gpkg", "release.tif"))
    found = released_by(opened)
    written = write(found, opened, folder)
    if quiet:
        return
    for path in written:
        print(path)
    print(f"released: {found.area:.4g} m2 in plan of {found.slab:.4g}, {found.thickness:.3g} m normal to the slope,"
          f" {found.volume:.4g} m3")
    if found.edge > 0.0:
        print(f"{100 * found.edge:.0f} % of its border is the border of the snow: the real area may be larger")
