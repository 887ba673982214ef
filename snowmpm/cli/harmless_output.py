"""Standard output that shows what others wrote, names of files and fields, and never acts on it."""

import re

CONTROL = "\x00-\x08\x0b-\x1a\x1c-\x1f\x7f-\x9f\u200e\u200f\u2028-\u202e\u2066-\u2069"
"""Characters that move the cursor, ring or turn the direction of reading, but for escape, tab and the end of a line."""
OF_A_FILE = re.compile(f"[{CONTROL}\x1b]")
OF_A_TERMINAL = re.compile(rf"[{CONTROL}]|\x1b(?!\[[0-9;]*m)")
"""Of escape sequences only those of colour and weight are ours."""


class HarmlessOutput:
    """A text stream that writes control characters by their numbers, as JSON and Python read them."""

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
