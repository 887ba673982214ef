"""`snowmpm docs`: the guides, in the terminal or the browser."""

import re
import sys
import tempfile
import webbrowser
from importlib import resources
from pathlib import Path
from typing import Annotated

import typer

from snowmpm.errors import InputError

Name = Annotated[str | None, typer.Argument(metavar="NAME", help="A guide; without one, they are listed.")]
InBrowser = Annotated[bool, typer.Option("--browser", help="Show the guide in the browser.")]

BESIDE = {"scenes": ("snowmpm.scenes", "README.md"), "tutorial": ("snowmpm.scenes", "TUTORIAL.md"),
          "materials": ("snowmpm.materials", "README.md")}
"""Guides that lie beside what they are about: (package, file)."""

PICTURE = re.compile(r"!\[([^\]]*)\]\(([^)]*)\)")


def guides():
    """{name: path} of the guides."""
    found = {name: resources.files(package) / file for name, (package, file) in BESIDE.items()}
    own = {path.name.removesuffix(".md"): path for path in resources.files("snowmpm.guides").iterdir()
           if path.name.endswith(".md")}
    return dict(sorted({**found, **own}.items()))


def docs(name: Name = None, browser: InBrowser = False):
    """Show a guide: when to use what, keys, formats, measured figures."""
    known = guides()
    if name is None:
        for one, path in known.items():
            print(f"{one:<16} {_heading(path)}")
        print("\nsnowmpm docs NAME shows one; --browser shows it with its tables and formulas in the browser")
        return
    if name not in known:
        raise InputError.not_in("NAME", name, known)
    text = known[name].read_text(encoding="utf-8")
    if browser:
        page = _page(name, text)
        print(page)
        webbrowser.open(page.as_uri())
        return
    from rich.console import Console
    from rich.markdown import Markdown

    # Pictures are not shipped: their words stand in their place
    shown = Markdown(PICTURE.sub(r"[picture: \1]", text))
    console = Console()
    if sys.stdout.isatty():
        with console.pager(styles=True):
            console.print(shown)
    else:
        console.print(shown)


def _heading(path):
    with path.open(encoding="utf-8") as lines:
        return next((line.strip("# \n") for line in lines if line.startswith("# ")), "")


def _page(name, text):
    """Write a guide as a page to a temporary file; -> its path."""
    from markdown_it import MarkdownIt

    from snowmpm.render.page import page, write_page

    body = MarkdownIt("commonmark", {"html": False}).enable("table").render(PICTURE.sub(r"*picture: \1*", text))
    path = Path(tempfile.mkdtemp(prefix="snowmpm-"), f"{name}.html")
    return write_page(path, page(name, body))
