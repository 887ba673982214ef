"""What a study varies of the way in which a problem is solved."""

from dataclasses import dataclass, field, replace

from snowmpm.sph.courant import USUAL as SPH_CFL
from snowmpm.stepping.time_step import critical_cfl, grain_stiffness, usual_cfl
from snowmpm.study.problems.schemes import Scheme

PROGRAM = Scheme("apic", precision="f32")
"""What a scene gets that says nothing about its solver."""


@dataclass(frozen=True)
class Variation:
    """A change of the program's own choice.

    group: what is varied, for the chart's legend; scheme: fields of `Scheme` that differ; per_axis: particles per cell
    and axis; step: C of the elastic limit over the program's own; options: keywords of a problem that it must know
    (offset, wall, return_map, dim).
    """

    name: str
    group: str
    scheme: dict = field(default_factory=dict)
    per_axis: int = 2
    step: float = 1.0
    options: dict = field(default_factory=dict)

    def solved(self, law, dim):
        """`Scheme` for a law, its time step included."""
        scheme = replace(PROGRAM, **self.scheme)
        if scheme.method == "sph":
            return replace(scheme, cfl=self.step * SPH_CFL)
        critical = critical_cfl(scheme.kernel, scheme.gradient, scheme.transfer, grain_stiffness(law, dim))
        return replace(scheme, cfl=min(self.step * usual_cfl(critical), LONGEST * critical))


LONGEST = 0.8
"""Share of the critical step that no variation goes beyond: finite strain stiffens a body."""

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
    Variation("half the step", "step", step=0.5),
    Variation("longer step", "step", step=1.4),
    Variation("longest step", "step", step=2.5),
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
