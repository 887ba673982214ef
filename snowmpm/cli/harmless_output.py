"""Standard output that shows names from files as text and never lets them act as control sequences."""

import re

CONTROL = "\x00-\x08\x0b-\x1a\x1c-\x1f\x7f-\x9f\u200e\u200f\u2028-\u202e\u2066-\u2069"
"""Control characters and marks of writing direction, without escape, tab and line feed."""
OF_A_FILE = re.compile(f"[{CONTROL}\x1b]")
OF_A_TERMINAL = re.compile(rf"[{CONTROL}]|\x1b(?!\[[0-9;]*m)")
"""The escape sequences that the program itself writes: colour and weight."""


class HarmlessOutput:
    """A text stream that escapes control characters as JSON and Python do."""

    def __init__(self, stream):
        self._stream = stream
        self._pattern = OF_A_TERMINAL if stream.isatty() else OF_A_FILE

    def write(self, text):
        self._stream.write(self._pattern.sub(lambda found: f"\\u{ord(found[0]):04x}", text))
        return len(text)

    def writelines(self, lines):
        for line in lines:
            self.write(line)

    def __getattr__(self, name):
        return getattr(self._stream, name)
