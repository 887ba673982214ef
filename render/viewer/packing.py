"""Arrays of a page as text: differences along rows, byte by byte, deflated, in base64. `web/unpack.js` reads them."""

import zlib

import numpy as np

from snowmpm.render.page import encoded

WHOLE = 65535  # of a place in a box, along each axis


class Parts:
    """Named arrays of whole numbers in the order in which they were added."""

    def __init__(self):
        self.table, self._packed = [], zlib.compressobj(6)
        self._bytes = []

    def add(self, name, values):
        """Add an array (n,) or (n, width) of uint8, int8, uint16 or uint32.

        Rows that are near each other in the array and in space differ little: their differences, modulo the range of
        the type, are small, and so are most of their high bytes, which are kept together.
        """
        values = np.ascontiguousarray(values)
        rows = values.reshape(len(values), 1 if values.ndim == 1 else values.shape[1])
        unsigned = rows.view(f"u{rows.itemsize}")
        steps = np.diff(unsigned, axis=0, prepend=np.zeros((1, rows.shape[1]), unsigned.dtype))
        planes = np.ascontiguousarray(steps.T).astype(f"<u{rows.itemsize}").view(np.uint8)
        planes = planes.reshape(-1, rows.itemsize).T
        self.table.append({"name": name, "type": values.dtype.kind + str(rows.itemsize), "rows": rows.shape[0],
                           "width": rows.shape[1]})
        self._bytes.append(self._packed.compress(planes.tobytes()))

    def add_bytes(self, name, data):
        """Add a file as it is, which is compressed already."""
        self.table.append({"name": name, "type": "raw", "rows": len(data), "width": 1})
        self._bytes.append(self._packed.compress(data))

    def text(self):
        """All of them in base64. Nothing can be added after."""
        return encoded(b"".join([*self._bytes, self._packed.flush()]))


def in_box(points, low, span):
    """Points (n, 3) in the box from `low`, of sides `span`, as uint16 shares of it."""
    return np.round(np.clip((points - low) / span, 0.0, 1.0) * WHOLE).astype(np.uint16)
