"""Variations of the numerical settings in a study."""

from dataclasses import dataclass, field, replace

from snowmpm.study.problems.schemes import Scheme

PROGRAM = Scheme("apic", precision="f32")
"""Default scheme, that of a scene without solver keys."""


@dataclass(frozen=True)
class Variation:
    """A change of the program's own choice.

    group: what is varied, for the chart's legend; scheme: fields of `Scheme` that differ; per_axis: particles per cell
    and axis; cfl: C of every step, the program's own choice when None; options: keywords of a problem that it must
    know (offset, wall, return_map, dim).
    """

    name: str
    group: str
    scheme: dict = field(default_factory=dict)
    per_axis: int = 2
    cfl: float | None = None
    options: dict = field(default_factory=dict)

    def solved(self, law, dim):
        """`Scheme` for a law; without a cfl of its own its steps follow the state, as those of a scene do."""
        scheme = replace(PROGRAM, **self.scheme)
        return scheme if self.cfl is None else replace(scheme, cfl=min(self.cfl, scheme.courant(law, dim)))


DEFAULT = Variation("program", "program")

VARIATIONS = (
    DEFAULT,
    Variation("float64", "precision", {"precision": "f64"}),
    Variation("cubic", "basis", {"kernel": "cubic"}),
    Variation("shape", "gradient", {"gradient": "shape"}),
    Variation("cubic, shape", "gradient", {"kernel": "cubic", "gradient": "shape"}),
    Variation("PIC", "transfer", {"transfer": "pic"}),
    Variation("FLIP 0.99", "transfer", {"transfer": "flip", "flip_ratio": 0.99}),
    Variation("FLIP 0.95", "transfer", {"transfer": "flip", "flip_ratio": 0.95}),
    Variation("AFLIP 0.99", "transfer", {"transfer": "aflip", "flip_ratio": 0.99}),
    Variation("classical", "transfer",
              {"transfer": "flip", "flip_ratio": 0.99, "kernel": "cubic", "gradient": "shape"}),
    Variation("1 per axis", "particles", per_axis=1),
    Variation("3 per axis", "particles", per_axis=3),
    Variation("cubic, 3 per axis", "particles", {"kernel": "cubic"}, per_axis=3),
    Variation("C = 0.2", "step", cfl=0.2),
    Variation("C = 0.4", "step", cfl=0.4),
    Variation("C = 0.56", "step", cfl=0.56),
    Variation("wall between nodes", "wall", options={"offset": 1.0 / 3.0}),
    Variation("walls as obstacles", "wall", options={"wall": "obstacle"}),
    Variation("frozen hardening", "return map", options={"return_map": "frozen"}),
    Variation("substepped", "return map", options={"return_map": "substepped"}),
    Variation("3-D", "dimension", options={"dim": 3}),
    Variation("SPH", "method", {"method": "sph"}),
)
BY_NAME = {variation.name: variation for variation in VARIATIONS}
QUICK = ("program", "cubic", "PIC", "FLIP 0.99", "3 per axis")
"""Variations of the short form, beside those of `options`."""
