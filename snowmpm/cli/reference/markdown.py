"""Text as Markdown: cells of tables, and words that are no markup."""

import html
import re


def plain(text):
    """Words on one line, their code spans kept, without other markup."""
    parts = " ".join(str(text).split()).split("`")
    if len(parts) % 2 == 0:  # a lone mark
        parts = ["'".join(parts)]
    return "`".join(part.replace("|", "\\|") if k % 2 else _quoted(part) for k, part in enumerate(parts))


def _quoted(words):
    return re.sub(r"([*\[\]_|\\])", r"\\\1", words.replace("<", "&lt;"))


def anchor(heading):
    """Where a link to a heading leads, as MkDocs makes it."""
    words = re.sub(r"[^\w\s-]", "", html.unescape(heading).lower())
    return re.sub(r"[-\s]+", "-", words.strip())


def code(text):
    """A code span that may stand in a cell."""
    return "`" + str(text).replace("|", "\\|") + "`" if text not in ("", None) else ""


def table(head, rows):
    """Lines of a table; cells as Markdown."""
    yield "| " + " | ".join(head) + " |"
    yield "|" + "---|" * len(head)
    for row in rows:
        yield "| " + " | ".join(row) + " |"
    yield ""
