"""Collapse of granular columns on a horizontal floor: final run-out and height from experiments.

With d0 half-width (radius), h0 height, a = h0/d0:

    plane    d/d0 = 1 + 1.2 a  (a < 2.3),  1 + 1.9 a^(2/3)         h/d0 = a  (a < 1.15),  c a^(2/5), c = 1.0 to 1.1
    round    d/d0 = 1 + 1.24 a (a < 1.7),  1 + 1.6 a^(1/2)         h/d0 = a  (a < 1.0),   0.88 a^(1/6)

They hold for sands, salt, rice and sugar on rough and smooth floors, whatever the friction of the grains.
"""

from snowmpm.comparison.answers.answer import Answer
from snowmpm.comparison.profile import profile
from snowmpm.comparison.quantity import Quantity
from snowmpm.errors import InputError

NEAR = 0.1
"""Half-widths or radii from the middle over which its height is a mean."""


def plane_runout(a):
    """d/d0 - 1 of a plane column of aspect ratio a."""
    return 1.2 * a if a < 2.3 else 1.9 * a ** (2.0 / 3.0)


def plane_height(a):
    """Least and largest h/d0 of a plane column."""
    return (a, a) if a < 1.15 else (a**0.4, 1.1 * a**0.4)


def round_runout(a):
    """d/d0 - 1 of a round column."""
    return 1.24 * a if a < 1.7 else 1.6 * a**0.5


def round_height(a):
    """Least and largest h/d0 of a round column."""
    return (a, a) if a < 1.0 else (0.88 * a ** (1.0 / 6.0),) * 2


class _Column(Answer):
    """Run-out from the middle and height there at the end of the run."""

    RUNOUT = HEIGHT = None

    def size(self):
        """Half-width or radius, and height at the start [m]."""
        raise NotImplementedError

    def reach(self, found):
        """How far a profile goes from the middle [m]."""
        raise NotImplementedError

    def quantities(self):
        d0, h0 = self.size()
        a = h0 / d0
        found = profile(self.case, self.case.run.frame(-1), self.centre())
        low, high = type(self).HEIGHT(a)
        middle = 0.0 if found.along == "r" else self.reference["centre"]
        near = abs(found.s - middle) <= max(NEAR * d0, abs(found.s - middle).min())
        reached = d0 * (1.0 + type(self).RUNOUT(a))
        return [Quantity.exact("run-out", "m", self.reach(found), reached),
                Quantity("height of the middle", "m", float(found.top[near].mean()), low * d0, high * d0)]

    def facts(self):
        d0, h0 = self.size()
        return {"aspect ratio": f"{h0 / d0:.3g}", **cone_facts(self.case.material)}


class PlaneColumn(_Column):
    """A box in plane strain, or the half of one beyond its middle."""

    SOURCE = ("Lube et al. (2005), doi:10.1103/PhysRevE.72.041301, as given by Fávero Neto and Borja (2018),"
              " doi:10.1007/s11440-018-0700-3, eqs. 33-34")
    RUNOUT, HEIGHT = staticmethod(plane_runout), staticmethod(plane_height)

    def size(self):
        shape = _shape(self.case, "box")
        return shape["max"][0] - self.reference["centre"], shape["max"][-1] - shape["min"][-1]

    def reach(self, found):
        centre = self.reference["centre"]
        half = _shape(self.case, "box")["min"][0] >= centre - 1e-9
        return found.front - centre if half else 0.5 * (found.front - found.back)


class RoundColumn(_Column):
    """An upright cylinder."""

    SOURCE = ("Lube et al. (2004), doi:10.1017/S0022112004009036, as given by Fávero Neto and Borja (2018),"
              " doi:10.1007/s11440-018-0700-3, eqs. 37-38")
    RUNOUT, HEIGHT = staticmethod(round_runout), staticmethod(round_height)

    def size(self):
        shape = _shape(self.case, "cylinder")
        return shape["radius"], shape["height"]

    def reach(self, found):
        return found.front

    def centre(self):
        return tuple(self.reference["centre"])


def _shape(case, kind):
    shape = case.body["shape"]
    if shape["kind"] != kind:
        raise InputError(f"{case.run.path}: bodies.0.shape.kind = {shape['kind']!r}: what is known of this scene is"
                         f" that of a {kind}")
    return shape


def cone_facts(material):
    """Which cone stands for the friction angle: its slope alpha = q/p says what the angle alone does not."""
    if material["kind"] != "drucker_prager":
        return {}
    from snowmpm.materials.cone import cone_slope

    angle, cone = material["friction_angle"], material["cone"]
    slope = cone_slope(angle, cone, material["dilation_angle"])
    return {"friction": f"{angle:g} degrees on the cone of {cone.replace('_', ' ')}: alpha = {slope:.4f}"}
