"""Colours of maps and curves can be told apart by readers who see no red, no green or no blue."""

import itertools

import numpy as np
import pytest

from snowmpm.gis.qgis_style import LINES
from snowmpm.quantities.classes import DEPTH, PRESSURE, SPEED, TIME
from snowmpm.render import campaign_plot, history_plot, peak_map, probability_map, saw_test_plot

EYES = {  # linear RGB as seen; G. M. Machado et al. (2009), doi:10.1109/TVCG.2009.113, table 1, severity 1
    "all": np.eye(3),
    "no green": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "no red": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "no blue": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
}
TO_XYZ = np.array([[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750],
                   [0.0193339, 0.1191920, 0.9503041]])
WHITE = np.array([0.95047, 1.0, 1.08883])


def lab(colour, eye):
    """CIE L*a*b* of a colour as an eye sees it."""
    c = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255.0
    linear = np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)
    x = TO_XYZ @ np.clip(np.array(EYES[eye]) @ linear, 0.0, 1.0) / WHITE
    f = np.where(x > 216 / 24389, np.cbrt(x), (24389 / 27 * x + 16) / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def difference(one, other):
    """CIEDE2000."""
    (L1, a1, b1), (L2, a2, b2) = one, other
    mean = 0.5 * (np.hypot(a1, b1) + np.hypot(a2, b2))
    G = 0.5 * (1.0 - np.sqrt(mean**7 / (mean**7 + 25.0**7)))
    a1, a2 = (1.0 + G) * a1, (1.0 + G) * a2
    C1, C2 = np.hypot(a1, b1), np.hypot(a2, b2)
    h1, h2 = (np.degrees(np.arctan2(b, a)) % 360.0 for a, b in ((a1, b1), (a2, b2)))
    dh = (h2 - h1 + 180.0) % 360.0 - 180.0 if C1 * C2 else 0.0
    dL, dC, dH = L2 - L1, C2 - C1, 2.0 * np.sqrt(C1 * C2) * np.sin(np.radians(0.5 * dh))
    L, C, h = 0.5 * (L1 + L2), 0.5 * (C1 + C2), h1 + 0.5 * dh
    T = (1.0 - 0.17 * np.cos(np.radians(h - 30.0)) + 0.24 * np.cos(np.radians(2.0 * h))
         + 0.32 * np.cos(np.radians(3.0 * h + 6.0)) - 0.2 * np.cos(np.radians(4.0 * h - 63.0)))
    SL = 1.0 + 0.015 * (L - 50.0) ** 2 / np.sqrt(20.0 + (L - 50.0) ** 2)
    SC, SH = 1.0 + 0.045 * C, 1.0 + 0.015 * C * T
    hue = ((h % 360.0) - 275.0) / 25.0
    R = -2.0 * np.sqrt(C**7 / (C**7 + 25.0**7)) * np.sin(np.radians(60.0 * np.exp(-(hue**2))))
    return float(np.sqrt((dL / SL) ** 2 + (dC / SC) ** 2 + (dH / SH) ** 2 + R * dC / SC * dH / SH))


CLASSES = {"pressure": PRESSURE.colours, "depth": DEPTH.colours, "speed": SPEED.colours, "time": TIME.colours,
           "probability": probability_map.COLOURS, "agreement": probability_map.AGREEMENT}
CURVES = {"history": history_plot.COLOURS[:7], "saw test": saw_test_plot.COLOURS, "campaign": campaign_plot.COLOURS,
          "lines of a map": (peak_map.RELEASE, peak_map.LINE, peak_map.OBSERVED, peak_map.BUILT),
          "lines in QGIS": tuple(dict.fromkeys(LINES[name] for name in ("release", "runout_line", "observed",
                                                                         "obstacles")))}


def test_difference_of_known_colours():
    """Pairs 1 and 17 of G. Sharma et al. (2005), doi:10.1002/col.20070, table 1."""
    assert difference((50.0, 2.6772, -79.7751), (50.0, 0.0, -82.7485)) == pytest.approx(2.0425, abs=1e-4)
    assert difference((50.0, 2.5, 0.0), (73.0, 25.0, -18.0)) == pytest.approx(27.1492, abs=1e-3)


@pytest.mark.parametrize("eye", EYES)
@pytest.mark.parametrize(("colours", "least"), [*((one, 7.5) for one in CLASSES.values()),
                                                *((one, 9.0) for one in CURVES.values())], ids=[*CLASSES, *CURVES])
def test_any_two_can_be_told_apart(colours, least, eye):
    seen = [lab(colour, eye) for colour in colours]
    worst = min(itertools.combinations(range(len(seen)), 2), key=lambda pair: difference(*(seen[i] for i in pair)))
    assert difference(*(seen[i] for i in worst)) >= least, [colours[i] for i in worst]
