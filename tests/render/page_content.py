"""A page as text that is checked, and header and arrays of an interactive page, read without its scripts."""

import base64
import json
import re
import zlib
from html.parser import HTMLParser

import numpy as np


class Tags(HTMLParser):
    """Start tags of a page with their attributes, and whether all are closed."""

    def __init__(self, text):
        super().__init__()
        self.found, self.open = [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.found.append((tag, dict(attributes)))
        if tag not in ("meta", "img", "input", "br"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open and self.open.pop() == tag, (tag, self.getpos())


def checked(path):
    """The text of a page, after checking that it is well formed and loads nothing."""
    text = path.read_text(encoding="utf-8")
    tags = Tags(text)
    assert tags.open == []
    for tag, attributes in tags.found:
        for name, value in attributes.items():
            assert not name.startswith("on"), (tag, name)
            if name == "href" and value.startswith("#"):
                assert any(there.get("id") == value[1:] for _, there in tags.found), value  # a place of the page
            elif name in ("src", "href", "data", "poster"):
                assert value.startswith("data:"), (tag, value[:60])
    assert "http-equiv" in text and "default-src 'none'" in text
    assert not re.search(r"(https?:)?//[a-z0-9.-]+\\.[a-z]{2,}", re.sub(r"base64,[^\"]*", "", text), re.IGNORECASE)
    assert "@import" not in text and "url(" not in text
    return text


def content(text):
    """(header, arrays by name, function from the shares of places to metres)."""
    head = json.loads(re.search(r'<script type="application/json">(.*?)</script>', text, re.DOTALL)[1])
    data = zlib.decompress(base64.b64decode(re.search(r'class="data">(.*?)</script>', text, re.DOTALL)[1]))
    parts, at = {}, 0
    for part in head["parts"]:
        n, width, size = part["rows"], part["width"], 1 if part["type"] == "raw" else int(part["type"][1])
        raw = np.frombuffer(data, np.uint8, n * width * size, at)
        at += len(raw)
        if part["type"] != "raw":
            planes = raw.reshape(size, width, n).astype(np.uint64)
            steps = sum(planes[k] << np.uint64(8 * k) for k in range(size))
            whole = np.cumsum(steps, axis=1) % (1 << 8 * size)
            raw = whole.T.astype(f"u{size}").view(f"{part['type'][0]}{size}")
        parts[part["name"]] = raw
    assert at == len(data)
    low, span = np.array(head["low"]), np.array(head["span"])
    return head, parts, lambda places: low + span * places / 65535.0
