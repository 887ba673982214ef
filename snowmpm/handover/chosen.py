"""Some of the particles of a method, as hand-overs read them."""


class Chosen:
    """The rows `rows` (n,) of `particles.fields.ParticleFields`."""

    def __init__(self, fields, rows):
        self._fields, self._rows = fields, rows

    def __getitem__(self, name):
        return self._fields[name][self._rows]

    def column(self, name):
        """One column of the store, float64."""
        return self._fields.column(name)[self._rows]
