"""A Matplotlib figure becomes a file."""

import os
from pathlib import Path

from matplotlib.backends.backend_agg import FigureCanvasAgg

from snowmpm.errors import InputError

ENDINGS = (".png", ".pdf", ".svg")


def check_ending(output):
    """Raises InputError unless `output` ends in one of ENDINGS."""
    if Path(output).suffix.lower() not in ENDINGS:
        raise InputError.at("output", str(output), f"must end in {', '.join(ENDINGS[:-1])} or {ENDINGS[-1]}")


def save(figure, output, dpi):
    """Draw `figure` to `output`, which is there complete or not at all. Returns its path."""
    path = Path(output)
    path.parent.mkdir(parents=True, exist_ok=True)
    draft = path.with_name(f".{path.stem}.unfinished{path.suffix}")
    try:
        FigureCanvasAgg(figure).print_figure(draft, dpi=dpi, bbox_inches="tight", pad_inches=0.15)
        os.replace(draft, path)
    finally:
        draft.unlink(missing_ok=True)
    return path
