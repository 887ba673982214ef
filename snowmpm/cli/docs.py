"""`snowmpm docs`: the guides and the pages of reference, in the terminal or the browser."""

import html
import re
import sys
import tempfile
import webbrowser
from importlib import resources
from pathlib import Path
from typing import Annotated

import typer

from snowmpm.cli import reference
from snowmpm.errors import InputError

Name = Annotated[str | None, typer.Argument(metavar="NAME", help="A guide or page of reference; without one, they are "
                                            "listed.")]
InBrowser = Annotated[bool, typer.Option("--browser", help="Show it in the browser, linked with all others.")]
Find = Annotated[str | None, typer.Option("--find", metavar="WORDS", help="Print the lines that contain these words.")]

PLACES = {"scenes": "scenes/README.md", "tutorial": "scenes/TUTORIAL.md", "materials": "materials/README.md",
          "conventions": "materials/CONVENTIONS.md"}
"""Guides that lie beside what they are about: where, in the repository and below the package."""

LINK = re.compile(r"(!?)\[([^\[\]\n]*(?:\n[^\[\]\n]+)?)\]\(([^)\s]*)\)")
HEADING = re.compile(r"<h([1-6])>(.*?)</h\1>")


def guides():
    """{name: path} of the guides; None for pages of reference, which are made when they are read."""
    found = {name: resources.files("snowmpm." + Path(file).parent.name) / Path(file).name
             for name, file in PLACES.items()}
    own = {path.name.removesuffix(".md"): path for path in resources.files("snowmpm.guides").iterdir()
           if path.name.endswith(".md")}
    return dict(sorted({**dict.fromkeys(reference.PAGES), **found, **own}.items()))


def docs(name: Name = None, browser: InBrowser = False, find: Find = None):
    """Show a guide: when to use what, keys, formats, measured figures."""
    known = guides()
    if name is not None and name not in known:
        raise InputError.not_in("NAME", name, known)
    if find is not None:
        _print_found(find, [name] if name else known)
    elif browser:
        page = _write_pages(known) / f"{name or 'index'}.html"
        print(page)
        webbrowser.open(page.as_uri())
    elif name is None:
        for one, path in known.items():
            print(f"{one:<21} {_heading(path) if path else reference.PAGES[one]}")
        print("\nsnowmpm docs NAME shows one; --browser shows them in the browser; --find WORDS searches them")
    else:
        _print(_told(_text(name)))


def _text(name):
    path = guides()[name]
    return reference.page(name) if path is None else path.read_text(encoding="utf-8")


def _heading(path):
    with path.open(encoding="utf-8") as lines:
        return next((line.strip("# \n") for line in lines if line.startswith("# ")), "")


def _print(text):
    from rich.console import Console
    from rich.markdown import Markdown

    if sys.stdout.isatty():
        console = Console()
        with console.pager(styles=True):
            console.print(Markdown(text))
    else:  # whole lines, which grep finds
        print(_unquoted(text))


def _print_found(words, names):
    """Lines of guides that contain some words, whatever their case."""
    found = 0
    for name in names:
        for line in _unquoted(_told(_text(name))).splitlines():
            if words.casefold() in line.casefold():
                found += 1
                print(f"{name}: {line.strip()}")
    if not found:
        print(f"no guide contains {words!r}")


def _unquoted(text):
    """Markdown without the marks that keep words from being markup."""
    return html.unescape(re.sub(r"\\([*\[\]_|\\])", r"\1", text))


def _target(address):
    """Name of the guide that a link leads to, and the place in it; (None, None) where it leads elsewhere."""
    path, _, place = address.partition("#")
    known = {file: name for name, file in PLACES.items()}
    path = path.removeprefix("../")
    name = known.get(path) or known.get(f"scenes/{path}") or Path(path).stem
    return (name, place) if path.endswith(".md") and name in guides() else (None, None)


def _told(text):
    """Markdown for the terminal: links say which guide they lead to, pictures are words."""

    def written(match):
        picture, words, address = match.groups()
        if picture:
            return f"[picture: {words}]"
        name, _ = _target(address)
        return match[0] if address.startswith("http") else f"{words} (`snowmpm docs {name}`)" if name else words

    return LINK.sub(written, text)


def _linked(text):
    """Markdown for pages beside each other."""

    def written(match):
        picture, words, address = match.groups()
        if picture:  # not shipped
            return f"*picture: {words}*"
        if address.startswith(("http", "#")):
            return match[0]
        name, place = _target(address)
        return f"[{words}]({name}.html{'#' + place if place else ''})" if name else words

    return LINK.sub(written, text)


def _write_pages(known):
    """Write all guides as pages to a temporary folder; -> the folder."""
    from markdown_it import MarkdownIt

    from snowmpm.cli.reference.markdown import anchor
    from snowmpm.render.page import page, write_page

    markdown = MarkdownIt("commonmark", {"html": False}).enable("table")
    folder = Path(tempfile.mkdtemp(prefix="snowmpm-"))
    others = " · ".join(f"[{name}]({name}.html)" for name in known)
    for name in known:
        body = markdown.render(f"[All guides by reader](index.html)\n\n{_linked(_text(name))}\n\n---\n\n{others}")
        body = HEADING.sub(lambda found: f'<h{found[1]} id="{anchor(re.sub("<[^>]*>", "", found[2]))}">{found[2]}'
                                         f"</h{found[1]}>", body)
        write_page(folder / f"{name}.html", page(name, body))
    return folder
