"""Friction by kind of ground: open slopes, channels, gullies and flats, by altitude and volume of the release.

The kind follows from the plan curvature of the smoothed ground [1/m], positive in hollows: open up to 0.002, channelled
at 0.010, gully from 0.050 on, interpolated between them. These are bounds of the Norwegian Geotechnical Institute for
the Swiss classes (its programs NAKSIN and MoT-Voellmy), which takes convex ground for flat; here ground is flat where
its slope is below 8 degrees, between 6 and 10 degrees in part. Numbers are interpolated over the volume of the release
and the altitude too.
"""

import numpy as np
from scipy import ndimage

from snowmpm.region.release_terrain import measures
from snowmpm.scenes.friction_cards import friction_card, law_for_volume

KINDS = "flat", "open", "channelled", "gully"
CURVATURES = 0.002, 0.01, 0.05
"""Curvature [1/m] at which the kinds but flat have their own numbers."""
LEVEL = 6.0, 10.0
"""Slopes [degrees] at which ground is all flat, and not flat: chosen."""
OVER = 100.0
"""Height [m] over which numbers change from one band of altitude to the next: chosen."""


def kinds(z, cell):
    """Shares (4, rows, columns) of KINDS, of heights with a halo of HALO cells."""
    found = measures(z, cell)
    hollow = ndimage.uniform_filter(np.nan_to_num(-found.curvature / 100.0), 3)
    at = np.interp(hollow, CURVATURES, np.arange(3.0))
    steep = np.interp(np.nan_to_num(found.slope, nan=90.0), LEVEL, (0.0, 1.0))
    return np.stack([1.0 - steep, *(steep * np.clip(1.0 - np.abs(at - k), 0.0, 1.0) for k in range(3))])


def numbers(classes, volume, z, shares):
    """mu and xi (rows, columns) of `spec.FrictionClass`es for a release of a volume [m3], over heights z [m].

    Between two classes of volume, numbers are interpolated; the bands of altitude change over OVER.
    """
    mu, turbulent = np.zeros(z.shape), np.zeros(z.shape)
    for share, kind in zip(shares, KINDS, strict=True):
        own = [one for one in classes if one.terrain == kind]
        by_volume = sorted({one.volume for one in own})
        tables = [_by_altitude([one for one in own if one.volume == size], z) for size in by_volume]
        found = [np.zeros(z.shape), np.zeros(z.shape)]
        for weight, table in zip(_weights(volume, by_volume), tables, strict=True):
            found = [total + weight * part for total, part in zip(found, table, strict=True)]
        mu += share * found[0]
        turbulent += share * found[1]
    return mu, 1.0 / turbulent


def _weights(value, knots):
    """Weights of linear interpolation between knots; of the first or the last beyond them."""
    at = np.interp(value, knots, np.arange(float(len(knots)))) if len(knots) > 1 else 0.0
    return np.clip(1.0 - np.abs(np.arange(len(knots)) - at), 0.0, 1.0)


def _by_altitude(classes, z):
    """mu and 1/xi (rows, columns) of classes that differ in altitude."""
    bands = sorted(classes, key=lambda one: one.above)
    knots, values = [], []
    for k, one in enumerate(bands):
        if k:
            knots.append(one.above - 0.5 * OVER)
            values.append((bands[k - 1].mu, 1.0 / bands[k - 1].xi))
        knots.append(one.above + (0.5 * OVER if k else 0.0))
        values.append((one.mu, 1.0 / one.xi))
    order = np.maximum.accumulate(knots)
    z = np.nan_to_num(z)
    return [np.interp(z, order, column) for column in np.transpose(values)]


def of_card(name, volume, factor):
    """Table `terrain.friction` of a scene: the law of a card for a volume [m3], its mu times a factor."""
    law = law_for_volume(friction_card(name), volume)
    given = law.model_dump(exclude_none=True)
    if factor != 1.0 and isinstance(given.get("mu"), float):
        given["mu"] = float(f"{factor * given['mu']:.9g}")
    return given
