"""What a scene is made of before a solver takes it: points with volume, material, velocity and initial stress."""

from dataclasses import dataclass
from dataclasses import field as dataclass_field

import numpy as np


@dataclass
class Population:
    """positions (n, dim) [m, scene coordinates], velocities (n, dim) [m/s], volumes (n,) [m3], material (n,) index.

    elastic: the laws' elastic variable be - I, stress: Kirchhoff stress [Pa]; both (n, 4) in plane strain or (n, 6),
    in the order xx, yy, zz, xy[, yz, xz]; zero where not given. volume_ratio (n,): J, 1 where not given; affine (n, dim
    * dim): velocity gradient [1/s]; state (n, k): of the laws, not a number where it is the law's initial one. field
    (n,): velocity field, 0 for all that moves as one continuum. starts (n,): when each may move [s]. columns: numbers
    of components, {name: (n, k)}, zero where not given. unstressed (n,): which get no initial stress.
    """

    positions: np.ndarray
    volumes: np.ndarray
    material: np.ndarray | int
    velocities: np.ndarray | None = None
    elastic: np.ndarray | None = None
    stress: np.ndarray | None = None
    volume_ratio: np.ndarray | None = None
    affine: np.ndarray | None = None
    state: np.ndarray | None = None
    field: np.ndarray | int = 0
    starts: np.ndarray | float = 0.0
    columns: dict = dataclass_field(default_factory=dict)
    unstressed: np.ndarray | bool = False

    @classmethod
    def joined(cls, parts):
        """One population of several, in this order."""
        def column(name):
            return np.concatenate([vars(part)[name] for part in parts])

        width = max((part.state.shape[1] for part in parts if part.state is not None), default=0)
        state = np.full((sum(len(part.volumes) for part in parts), width), np.nan)
        ends = np.cumsum([0, *(len(part.volumes) for part in parts)])
        for part, begin, end in zip(parts, ends, ends[1:], strict=False):
            if part.state is not None:
                state[begin:end, : part.state.shape[1]] = part.state
        names = ("positions", "volumes", "material", "velocities", "elastic", "stress", "volume_ratio", "affine")
        return cls(**{name: column(name) for name in names}, state=state if width else None, field=column("field"),
                   starts=column("starts"), columns=cls._columns(parts), unstressed=column("unstressed"))

    @staticmethod
    def _columns(parts):
        """Columns of components, zero where a part has none of them."""
        widths = {name: values.shape[1] for part in parts for name, values in part.columns.items()}
        return {name: np.concatenate([part.columns.get(name, np.zeros((len(part.volumes), width))) for part in parts])
                for name, width in widths.items()}

    def __post_init__(self):
        n, dim = self.positions.shape
        symmetric = 4 if dim == 2 else 6
        self.material = np.broadcast_to(np.asarray(self.material, np.int32), n).copy()
        self.velocities = np.zeros((n, dim)) if self.velocities is None else np.asarray(self.velocities, float)
        self.elastic = np.zeros((n, symmetric)) if self.elastic is None else self.elastic
        self.stress = np.zeros((n, symmetric)) if self.stress is None else self.stress
        self.volume_ratio = np.ones(n) if self.volume_ratio is None else self.volume_ratio
        self.affine = np.zeros((n, dim * dim)) if self.affine is None else self.affine
        self.field = np.broadcast_to(np.asarray(self.field, np.int64), n).copy()
        self.starts = np.broadcast_to(np.asarray(self.starts, float), n).copy()
        self.unstressed = np.broadcast_to(np.asarray(self.unstressed, bool), n).copy()
