"""Self-contained HTML: what a page is made of. Every text is escaped, every picture inside, nothing is loaded."""

import base64
import html
from pathlib import Path

from snowmpm.annotations import PathLike
from snowmpm.draft import write_text
from snowmpm.render import document as content

FOLDER = Path(__file__).parent / "web"
TYPES = {".png": "image/png", ".jpg": "image/jpeg", ".svg": "image/svg+xml", ".mp4": "video/mp4"}
# A page that is shared may not reach out, whatever a name or a file in it holds.
POLICY = "default-src 'none'; img-src data:; media-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'"


def escaped(text):
    """Any value as text of a page."""
    return html.escape(str(text), quote=True)


def page(title, body, *, whole=False, refresh=None):
    """A whole page from its title and the HTML of its body; whole: the body fills the window; refresh: seconds after
    which the browser opens it again."""
    style = (FOLDER / "page.css").read_text(encoding="utf-8")
    kind = ' class="whole"' if whole else ""
    again = f'<meta http-equiv="refresh" content="{refresh}">\n' if refresh else ""
    return (f'<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
            f'<meta name="viewport" content="width=device-width, initial-scale=1">\n'
            f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">\n'
            f"{again}<title>{escaped(title)}</title>\n<style>\n{style}</style>\n</head>\n<body>\n<main{kind}>\n{body}\n"
            f"</main>\n</body>\n</html>\n")


def section(title, *parts):
    """A headed part of a page; nothing when all parts are empty."""
    inner = "\n".join(part for part in parts if part)
    return f"<h2>{escaped(title)}</h2>\n{inner}" if inner else ""


def table(rows, named=None):
    """Names and values in two columns, from a dictionary of texts; nothing when it is empty.

    named: `Quantity` by row name: its name leads to its definition, which also shows where the pointer rests.
    """
    named = named or {}
    cells = "".join(f"<tr><td>{_linked(name, named.get(name))}</td><td class=number>{escaped(value)}</td></tr>\n"
                    for name, value in rows.items())
    return f"<table>\n{cells}</table>" if cells else ""


def _linked(words, quantity):
    if quantity is None or not quantity.definition:
        return escaped(words)
    return f'<a href="#{escaped(quantity.name)}" title="{escaped(quantity.definition)}">{escaped(words)}</a>'


def definitions(quantities):
    """What quantities mean, each under its name, where links lead."""
    inner = "".join(f'<dt id="{escaped(one.name)}">{escaped(one.label)} <code>{escaped(one.name)}</code></dt>'
                    f"<dd>{escaped(one.definition)}</dd>\n" for one in quantities)
    return f"<dl>\n{inner}</dl>" if inner else ""


def page_of(document):
    """A whole page from a `snowmpm.render.document.Document`."""
    parts = [f"<h1>{escaped(document.title)}</h1>", f'<p class="lead">{escaped(document.lead)}</p>']
    for one in document.sections:
        inner = [block(part) for part in one.blocks]
        parts.append(section(one.title, *inner) if one.title else "\n".join(part for part in inner if part))
    parts += [f"<footer>{escaped(document.foot)}</footer>", script(*document.scripts) if document.scripts else ""]
    return page(document.title, "\n".join(part for part in parts if part))


def block(part):
    """One block of a document as HTML."""
    match part:
        case content.Numbers(rows):
            return numbers(rows)
        case content.Note(text, kind):
            return note(text, kind)
        case content.Paragraph(text):
            return f'<p class="lead">{escaped(text)}</p>'
        case content.Picture(path, words):
            return figure(path, words)
        case content.Columns(pictures):
            return columns(figure(one.path, one.words) for one in pictures)
        case content.Table(rows, named):
            return table(rows, named)
        case content.Listing(text, summary):
            return listing(text, summary)
        case content.Definitions(quantities):
            return definitions(quantities)
        case content.Live(html_text):
            return html_text
    raise TypeError(f"not a block of a document: {type(part).__name__}")


def numbers(rows):
    """A few numbers that matter most, large: value by what it is."""
    return "<div class=numbers>" + "".join(
        f"<div><b>{escaped(value)}</b><span>{escaped(name)}</span></div>" for name, value in rows.items()) + "</div>"


def columns(parts):
    """Parts side by side where there is room; nothing when there is none."""
    inner = "\n".join(parts)
    return f"<div class=columns>{inner}</div>" if inner else ""


def note(text, kind="warning"):
    """A marked line: "warning" or "good"."""
    return f'<div class="{escaped(kind)}">{escaped(text)}</div>'


def listing(text, summary=None):
    """Text as it is, in a fixed pitch; with a summary it is folded in."""
    inner = f"<pre>{escaped(text)}</pre>"
    return inner if summary is None else f"<details><summary>{escaped(summary)}</summary>{inner}</details>"


def figure(path, words=""):
    """A picture or film file with a line below."""
    path = Path(path)
    kind = TYPES[path.suffix.lower()]
    source = f"data:{kind};base64,{encoded(path.read_bytes())}"
    shown = (f'<video controls loop muted playsinline src="{source}"></video>' if kind.startswith("video")
             else f'<img alt="{escaped(words)}" src="{source}">')
    return f"<figure>{shown}<figcaption>{escaped(words)}</figcaption></figure>"


def encoded(data):
    """Bytes as base64 text."""
    return base64.b64encode(data).decode("ascii")


def script(*names):
    """Scripts of this package, as one element."""
    text = "\n".join((FOLDER / name).read_text(encoding="utf-8") for name in names)
    return f"<script>\n{text}</script>"


def write_page(path: PathLike, text: str) -> Path:
    """Write a page, which is there complete or not at all; -> its path."""
    return write_text(path, text)
