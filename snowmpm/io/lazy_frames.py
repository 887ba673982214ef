"""A particle field of all frames as one array that reads only the requested part of the run file."""

import numpy as np


class FrameArray:
    """Field `name` of a run, or its "position" in map coordinates: shape (frames, rows[, components]).

    rows: of the largest frame. Frames with fewer particles end in NaN, so whole numbers of such runs are floats.
    """

    def __init__(self, run, name, rows):
        self._run, self._name = run, name
        dtype, columns = (np.dtype(np.float64), 3) if name == "position" else run.field_kinds[name]
        ragged = any(run.n_points(i) < rows for i in range(len(run)))
        self.dtype = np.dtype(np.float64) if ragged and dtype.kind != "f" else dtype
        self.shape = (len(run), rows) if columns is None else (len(run), rows, columns)

    def _values(self, i):
        if self._name == "position":
            return self._run.frame(i, []).positions
        return self._run.frame(i, [self._name]).fields[self._name]

    def read(self, key):
        """Values by a key of whole numbers and slices, one an axis."""
        times = np.arange(self.shape[0])[key[0]]
        wanted = [self._filled(int(i))[tuple(key[1:])] for i in np.atleast_1d(times)]
        if np.ndim(times) == 0:
            return wanted[0]
        if not wanted:
            return np.zeros((0, *np.empty(self.shape[1:], bool)[tuple(key[1:])].shape), self.dtype)
        return np.stack(wanted)

    def _filled(self, i):
        values = self._values(i)
        if len(values) == self.shape[1] and values.dtype == self.dtype:
            return values
        filled = np.full(self.shape[1:], np.nan if self.dtype.kind == "f" else 0, self.dtype)
        filled[: len(values)] = values
        return filled

    def variable_data(self, xarray):
        """Backend array for a variable of xarray."""
        from xarray.backends import BackendArray
        from xarray.core import indexing

        own = self

        class Lazy(BackendArray):
            """Values for an indexer of xarray."""

            shape, dtype = own.shape, own.dtype

            def __getitem__(self, key):
                return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.BASIC, own.read)

        return indexing.LazilyIndexedArray(Lazy())
