"""All models of run-out on one path, and over one raster."""

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np

from snowmpm.errors import InputError
from snowmpm.ground import Coulomb, Voellmy
from snowmpm.runout.alpha_beta import AlphaBeta, alpha_beta
from snowmpm.runout.block import GRAVITY, block, energy_line
from snowmpm.runout.profile import Profile, profile_of
from snowmpm.runout.routing import USUAL, Routed, Routing, main_way, route

FAR = Routing(angle=12.0, exponent=75.0)
"""With which the path is found, when none is given: further than nearly all avalanches go, and where most snow goes."""


MOST_TRIED = 200
"""Cells of a release from which a way is looked for."""
BESIDE = 3.0
"""Cells from the release within which a path begins at it."""
FOLD = 90.0
"""Turn of a path [degrees] beyond which it is folded."""


@dataclass(frozen=True)
class Reach:
    """model: its name; s [m]: length along the path to where it stops, None where the path ends before; place (2,),
    height [m]; angle [degrees]: from the upper end; speed [m/s]: largest, None of statistics; note: in words."""

    model: str
    s: float | None
    place: Any
    height: float | None
    angle: float | None
    speed: float | None
    note: str = ""


@dataclass(frozen=True)
class Runout:
    """profile; given: whether its path was given; statistics: `AlphaBeta`, or None, with the reason; reaches: of all
    models; speeds: (n,) [m/s] along the profile by model; routed: rasters; routing: its numbers; more: what else to
    know, in words."""

    profile: Profile
    given: bool
    statistics: AlphaBeta | None
    reason: str
    reaches: list[Reach]
    speeds: dict[str, np.ndarray]
    routed: Routed
    routing: Routing
    more: tuple[str, ...] = ()

    @property
    def doubts(self):
        """Why numbers may not hold, in words."""
        own = self.statistics.doubts if self.statistics else ()
        return [*own, *([self.reason] if self.reason else []), *self.more]


def runout(ground, line=None, where="--path", calibration="austria", split=None, routing=USUAL, lists=1):
    """`Runout` on a `ground.Ground`. line (k, 2) [m]: path, from a file named `where`; the way of most snow from the
    top of the release by default; split [m]: see `alpha_beta`. Raises InputError."""
    given = line is not None
    if not given:
        where, line = "the way of most snow", way_of(ground)
    profile = profile_of(line, ground.height, where)
    routed = route(ground.z, ground.cell, ground.release, routing, lists)
    statistics, why = None, ""
    try:
        statistics = alpha_beta(profile, calibration, split)
    except InputError as error:
        if str(error).startswith("--"):  # of an option
            raise
        why = f"alpha-beta: {error}"
    reaches, speeds = [], {}
    if statistics:
        for n, s in statistics.runouts.items():
            sd = "" if n == 0 else f" {'+' if n > 0 else '-'} {abs(n)} SD".replace("1 SD", "SD")
            reaches.append(_reach(profile, f"alpha{sd}", s, angle=statistics.alpha + n * statistics.deviation))
    slides = {f"energy line of {routing.angle:g} degrees": energy_line(profile, routing.angle),
              **(blocks := blocks_of(profile, ground.friction, ground.thickness))}
    for name, slide in slides.items():
        reaches.append(_reach(profile, name, slide.runout, speed=slide.fastest))
        speeds[name] = slide.speed
    if not blocks:
        reason = "needs Coulomb's or Voellmy's friction, in numbers"
        reaches.append(Reach("block", None, None, None, None, None, reason))
    reaches.append(_of_routing(ground, routed))
    return Runout(profile, given, statistics, why, reaches, speeds, routed, routing,
                  tuple(_more(ground, profile, routed)))


def way_of(ground):
    """Places of the way of most snow from the highest cell of the release from which some gets away."""
    for cell in ground.release[: MOST_TRIED]:
        line = _unfolded(on_ground(ground, ground.places(main_way(ground.z, ground.cell, cell, FAR))))
        if len(line) > 1:
            return line
    raise InputError(f"{ground.source}: bodies: no snow gets away from the release above {FAR.angle:g} degrees: give a"
                     " path with --path")


def _unfolded(line):
    """A line as far as it does not turn back."""
    pieces = np.diff(line, axis=0)
    folds = np.flatnonzero((pieces[1:] * pieces[:-1]).sum(axis=1) <= 0.0)
    return line[: 2 + folds[0]] if len(folds) else line


def _more(ground, profile, routed):
    """What else to know of the numbers."""
    places = ground.places(ground.release)
    away = float(np.linalg.norm(places - profile.plan[0], axis=1).min())
    if away > BESIDE * ground.cell:
        yield f"the path begins {away:.0f} m beside the release: lengths and angles are from its upper end"
    turn, s = profile.sharpest
    if turn > FOLD:
        yield f"the path turns by {turn:.0f} degrees at {s:.0f} m: models along it do not hold beyond"
    if routed.at_edge:
        yield "routing reaches the end of the ground, which lets no snow through: how far it goes cannot be told"
    if ground.ignored:
        yield f"not in these models: {', '.join(ground.ignored)}"


def on_ground(ground, line):
    """A line (k, 2), as far as the ground is known between its corners."""
    between = [np.linspace(a, b, 8) for a, b in itertools.pairwise(line)]
    known = [bool(np.isfinite(ground.height(places)).all()) for places in between]
    return line[: 1 + (known.index(False) if False in known else len(known))]


def blocks_of(profile, law, thickness):
    """{name: `Slide`} of a block with the friction of the ground, where that is Coulomb's or Voellmy's; else {}."""
    numbers = block_friction(law)
    if numbers is None:
        return {}
    name = f"block, {'Coulomb' if len(numbers) == 1 else 'Voellmy'} {', '.join(f'{one:g}' for one in numbers)}"
    return {name: block(profile, *numbers, *([thickness] if len(numbers) > 1 else []))}


def block_friction(law):
    """(mu,) of Coulomb's friction, (mu, xi [m/s2]) of Voellmy's, in numbers; None of another."""
    if isinstance(law, Coulomb) and not law.rasters:
        return (law.mu,)
    if isinstance(law, Voellmy) and not law.rasters and not law.tau0 and not law.cohesion:
        return law.mu, law.xi if law.xi is not None else GRAVITY / law.k
    return None


def _reach(profile, model, s, angle=None, speed=None):
    if s is None:
        return Reach(model, None, None, None, angle, speed, "beyond the end of the path")
    if s == 0.0:
        return Reach(model, 0.0, profile.plan[0], float(profile.z[0]), angle, speed, "does not start")
    place, height = profile.at(s)
    found = float(np.degrees(np.arctan2(profile.z[0] - height, s))) if s > 0.0 else None
    return Reach(model, s, place, height, found if angle is None else angle, speed)


def _of_routing(ground, routed):
    """The longest way of routing, and the place that it leads to."""
    cell = np.unravel_index(int(np.nanargmax(routed.length)), routed.length.shape)
    s, height = float(routed.length[cell]), float(ground.z[cell])
    angle, note = float(routed.angle[cell]), "at least: it reaches the end of the ground" if routed.at_edge else ""
    return Reach("routing, longest way", s, ground.places([cell])[0], height, angle if np.isfinite(angle) else None,
                 float(np.sqrt(2.0 * GRAVITY * np.nanmax(routed.energy))), note)
