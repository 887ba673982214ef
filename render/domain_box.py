"""The box in which a run follows its snow, as its scene gives it."""

from dataclasses import dataclass

from snowmpm.errors import InputError


@dataclass(frozen=True)
class DomainBox:
    """lower, upper {axis: [m] relative to the origin of the run}, empty where the scene leaves them to the program;
    sides {"x_min": word}: those that it names."""

    lower: dict[str, float]
    upper: dict[str, float]
    sides: dict[str, str]

    @classmethod
    def of(cls, run):
        """Of a `Run`. Raises InputError where nothing of it can be read."""
        try:
            domain = run.scene.get("domain") or {}
            axes = "xz" if run.dimension == 2 else "xyz"
            sides = domain.get("boundary") or {}
            sides = sides if isinstance(sides, dict) else {f"{a}_{end}": sides for a in axes for end in ("min", "max")}
            ends = [{a: float(x) - float(run.origin["xyz".index(a)]) for a, x in zip(axes, corner, strict=True)}
                    for corner in (domain.get("min") or [None] * len(axes), domain.get("max") or [None] * len(axes))
                    if None not in corner]
            return cls(*(ends if len(ends) == 2 else ({}, {})), dict(sides))
        except (InputError, LookupError, TypeError, ValueError, AttributeError):
            raise InputError(f"{run.path}: says nothing readable of the sides of its domain") from None
