"""The gallery: a picture of every library scene, drawn from its run, and the page that shows them.

Each picture carries the facts of its run as text, so that the page can be rewritten from the pictures alone.
"""

import re
from pathlib import Path

from snowmpm.draft import write_text
from snowmpm.errors import InputError, shown_line
from snowmpm.io import Run
from snowmpm.io.checkpoint import differences
from snowmpm.io.layout import RUN_FILE
from snowmpm.render import PLOTS, notes_of, render_strip
from snowmpm.running.rest import rested
from snowmpm.scenes import library
from snowmpm.scenes.library import comment

PAGE = "README.md"

CAPTION = re.compile(r"^!\[.*\]\((.+\.png)\)\n\n(.+ particles, dx = .+)$", re.MULTILINE)
"""A picture on the page and the line below it."""

LABEL = re.compile(r"^([A-Za-z_.]+): ")
"""What a line of a comment begins with where it speaks of one thing: a key, what is published, what was chosen."""

HEAD = """# Gallery

Every scene of the library as `snowmpm run NAME` computes it. One command, `snowmpm gallery`, makes pictures and page.
The section `[picture]` of each scene says what its picture shows and when. The text is that of the scene files.
"""


def run_of(scene, folder):
    """The run of this scene in `folder`, finished or not, or None.

    Raises InputError if the run there is of another scene, or of this scene with other values.
    """
    if not (Path(folder) / RUN_FILE).exists():
        return None
    run = Run(folder)
    different = next(differences(run.provenance["scene"], scene), None)
    if different is None and run.complete and run.times[-1] < scene.end_time * (1.0 - 1e-9) and not rested(run):
        different = "end_time", float(run.times[-1]), scene.end_time
    if different is not None:
        key, was, now = different
        raise InputError(f"{folder}: holds a run of another scene: {key} is {was!r} there and {now!r} in"
                         f" {scene.source}; --overwrite it, or keep runs in another folder with --runs")
    return run


def draw_exhibit(scene, run, folder, settings=()):
    """Draw the picture of a scene from its finished run; -> its path, `folder`/NAME.png.

    settings: changes to the library's scene, texts KEY=VALUE for the page.
    """
    chosen = scene.picture
    plots = () if chosen.plot is None else (PLOTS[chosen.plot],)
    target = Path(folder) / f"{scene.name}.png"
    return render_strip(run, target, times=chosen.times, color=chosen.color, camera=chosen.camera, size=chosen.size,
                        inset=chosen.inset, plots=plots, notes=_facts(scene, run, settings or ()))


def _facts(scene, run, settings):
    summary, origin = run.summary, run.provenance
    return {"particles": summary["particles"], "steps": summary["steps"], "wall_time": summary["wall_time"],
            **({"processor_time": summary["processor_time"]} if "processor_time" in summary else {}),
            "device": origin.get("device", origin["backend"]), "dx": scene.solver.dx, "time": float(run.times[-1]),
            "dimension": scene.dimension, "version": origin["version"],
            "settings": ", ".join(text for text in settings if not text.startswith("picture."))}


def write_page(folder, in_words):
    """Write the page of all library scenes; -> (its path, names of scenes that have no picture).

    in_words: facts by name, as texts -> the line below a picture, empty where it has none: a picture that was made
    smaller elsewhere keeps the line that the page has.
    """
    sections, missing, page = [HEAD], [], Path(folder) / PAGE
    before = dict(CAPTION.findall(page.read_text(encoding="utf-8"))) if page.is_file() else {}
    for name, title in library().items():
        picture = Path(folder) / f"{name}.png"
        sections.append(f"## {name}\n\n**{title}**\n")
        if picture.is_file():
            caption = _in_markdown(in_words, picture) or before.get(picture.name, "")
            sections.append(f"![{title}]({picture.name})\n\n{caption}\n")
        else:
            missing.append(name)
            sections.append(f"No picture yet: `snowmpm gallery {name}`.\n")
        sections.append(_as_markdown(comment(name)[1:]) + "\n")
    return write_text(page, "\n".join(sections)), missing


def _in_markdown(in_words, picture):
    """The caption of a picture; its notes are escaped, since anybody may have written them."""
    try:
        words = in_words({name: shown_line(text, 200) for name, text in notes_of(picture).items()})
    except (LookupError, ValueError, OverflowError):
        raise InputError(f"{picture}: its notes are not those of this program: draw it again") from None
    return re.sub(r"([\\`*_\[\]<>|#!])", r"\\\1", words)


def _as_markdown(lines):
    """A comment as Markdown: indented lines, which are commands, become code; `Published: ...` begins a paragraph."""
    text, inside = [], False
    for line in lines:
        if line.startswith("  ") != inside:
            text.append("```")
            inside = not inside
        if LABEL.match(line) and text and text[-1] not in ("", "```"):
            text.append("")
        text.append(LABEL.sub(r"**\1**: ", line).strip())
    return "\n".join([*text, "```"] if inside else text).strip()
