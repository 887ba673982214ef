"""A material card from a sample of grains: the numbers of a law, where they are from, and how far they hold."""

LAW = "Gaume et al. (2018), doi:10.1038/s41467-018-05181-w"


def card_of(fitted, curves, sample, made):
    """Tables of a card (`scenes.cards`) of a `FittedLaw`. sample: the `Assembly`; made: numbers of its making."""
    law = fitted.law
    said = ", ".join(f"{name} {low:.3g} to {high:.3g}" for name, (low, high) in fitted.intervals.items())
    missed = ", ".join(f"{name} {100.0 * error:.0f} %" for name, error in fitted.errors.items())
    numbers = ", ".join(f"{name} {value:g}" for name, value in made.items())
    closing = -float(curves[0].jump[:, 2].min())
    tests = ", ".join(curve.name for curve in curves)
    return {"description": f"Fitted to {len(sample.radii)} bonded grains by snowmpm grains",
            "source": f"Law: {LAW}. Numbers: least squares to {len(curves)} tests ({tests}) of a periodic cell of"
                      f" bonded spheres (discrete elements): {numbers}",
            "validity": f"Compaction up to {closing:g}. 95 % intervals: {said}. Root mean square differences over the"
                        f" largest stress: {missed}. One sample: another one of as many grains may differ by more than"
                        " the intervals",
            "material": {key: _rounded(value) for key, value in law.model_dump(exclude_none=True).items()
                         if key in ("kind", "density", *fitted.intervals)}}


def _rounded(value):
    return value if isinstance(value, str) else float(f"{value:.6g}")
