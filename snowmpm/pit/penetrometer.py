"""Profiles of the SnowMicroPen (.pnt): force against depth, and density from its shot noise.

Windows overlap by half. In each, of force F [N] at spacing dx [mm] without its linear trend, C the covariance
(Löwe & van Herwijnen 2012, doi:10.1016/j.coldregions.2011.09.001):

    delta = -3/2 C(0) dx / (C(1) - C(0)),   lambda = 4/3 mean(F)^2 / (var(F) delta),   L = (A / lambda)^(1/3)

with A = pi 2.5^2 mm2 of the tip. Density by a fit to its own instrument and window, with the median force and L [mm]
(Proksch et al. 2015, doi:10.1002/2014JF003266):

    rho = a0 + a1 ln F + a2 L ln F + a3 L
"""

import io
import itertools
import math
import struct

import numpy as np

from snowmpm.errors import InputError, shown_line
from snowmpm.pit.profile import ICE_DENSITY, LIGHTEST, Layer, SnowProfile, checked
from snowmpm.reading.limited import read_limited

HEADER = 512
MAX_SAMPLES = 4_000_000
LONGEST = 10_000.0
"""Way of the rod [mm]."""
AREA = math.pi * 2.5**2
"""[mm2]"""
FIT, WINDOW = (420.47, 102.47, -121.15, -169.96), 2.5
"""Coefficients a0 to a3 and window [mm]."""
AIR = 0.03
"""Force [N] of air, at most: noise of the sensor; snow begins where the force stays above it."""
STAYS = 2.0
"""Length [mm] over which it must."""
ALIKE = 0.12
"""Windows whose densities differ by less belong to one layer, as share of the mean."""
LEAST_LAYER = 0.005
"""[m]"""


def read_pnt(path):
    """The profile of a file. Raises InputError, and OSError."""
    force, spacing, header = read_force(path)
    surface, ground = _snow(force, spacing, header["overload"])
    notes = ["density by the fit of Proksch et al. (2015) to the shot noise of the force, made for one version of the"
             " instrument", "grain forms are not measured", "the depth is along the rod, taken as vertical"]
    if ground is None:
        notes.append("the ground was not reached")
    force = force[surface:ground]
    depth, density = densities(force, spacing)
    if len(depth) < 2:
        raise InputError(f"{path}: less than two windows of snow in {len(force) * spacing:.0f} mm: no profile")
    return checked(SnowProfile(
        name=shown_line(path.stem, 100), source=str(path), format="SnowMicroPen", time=header["time"],
        place=header["place"], layers=tuple(_layers(depth, density)), notes=tuple(notes)))


def read_force(path):
    """(force (n,) [N], spacing [mm], header). Raises InputError for what is no such file or is cut off."""
    content = read_limited(path, HEADER + 2 * MAX_SAMPLES + (1 << 20))
    size = len(content)
    with io.BytesIO(content) as file:
        head = file.read(HEADER)
        if len(head) < HEADER:
            raise InputError(f"{path}: no file of a SnowMicroPen: {size} bytes, and its header has {HEADER}")
        (firmware,), (spacing, factor) = struct.unpack_from(">h", head, 0), struct.unpack_from(">2f", head, 6)
        (count,), (overload,) = struct.unpack_from(">l", head, 358), struct.unpack_from(">h", head, 380)
        sound = 0 < firmware < 1000 and 1e-4 < spacing < 1.0 and 0.0 < abs(factor) < 10.0
        if not sound or not 0 < count <= MAX_SAMPLES:
            raise InputError(f"{path}: no file of a SnowMicroPen: firmware {firmware}, {count} samples, spacing"
                             f" {spacing:g} mm, {factor:g} N/mV")
        if count * spacing > LONGEST:
            raise InputError(f"{path}: no file of a SnowMicroPen: {count} samples of {spacing:g} mm are"
                             f" {1e-3 * count * spacing:.0f} m")
        if size < HEADER + 2 * count:
            raise InputError(f"{path}: cut off: {(size - HEADER) // 2} of {count} samples")
        raw = file.read(2 * count)
    dates = struct.unpack_from(">6h", head, 20)
    latitude, longitude = struct.unpack_from(">2f", head, 264)
    known = math.isfinite(latitude) and 0.0 < abs(latitude) <= 90.0 and abs(longitude) <= 180.0
    return np.frombuffer(raw, ">i2") * float(factor), float(spacing), {
        "time": "{:04d}-{:02d}-{:02d} {:02d}:{:02d}:{:02d}".format(*dates), "overload": float(overload),
        "place": (round(latitude, 6), round(longitude, 6)) if known else None}


def _snow(force, spacing, overload):
    """First sample of snow and, where the tip met its largest force, the sample before the ground; else None."""
    stays = max(1, round(STAYS / spacing))
    mean = np.convolve(force, np.full(stays, 1.0 / stays), "valid") if stays < 1000 else force
    noise = np.median(mean[: max(1, len(mean) // 100)])
    above = np.flatnonzero(mean > noise + AIR)
    surface = int(above[0]) if len(above) else 0
    hit = np.flatnonzero(force >= 0.95 * overload) if overload > 0.0 else ()
    return surface, int(hit[0]) - stays if len(hit) and hit[0] - stays > surface else None


def densities(force, spacing):
    """Depths of the middles of windows [m] and their densities [kg/m3]."""
    (a0, a1, a2, a3), n = FIT, round(WINDOW / spacing)
    starts = range(0, len(force) - n + 1, max(1, n // 2))
    line = np.arange(n) - 0.5 * (n - 1)
    depth, density = [], []
    for start in starts:
        part = force[start:start + n]
        mean, median = part.mean(), np.median(part)
        rest = part - mean - (line @ (part - mean)) / (line @ line) * line
        c0, c1 = rest @ rest / n, rest[1:] @ rest[:-1] / n
        if median <= 0.0 or not 0.0 < c1 < c0:
            continue
        delta = 1.5 * c0 * spacing / (c0 - c1)
        length = (AREA * c0 * delta / (4.0 / 3.0 * mean**2)) ** (1.0 / 3.0)
        value = a0 + a1 * math.log(median) + a2 * length * math.log(median) + a3 * length
        if LIGHTEST <= value <= ICE_DENSITY:
            depth.append(1e-3 * spacing * (start + 0.5 * n))
            density.append(value)
    return np.array(depth), np.array(density)


def _layers(depth, density):
    """Layers of windows alike: neighbours are joined, the most alike ones first, until all others differ by ALIKE, or
    are no thinner than LEAST_LAYER."""
    middles = 0.5 * (depth[1:] + depth[:-1])
    edges = np.concatenate([[0.0], middles, [2.0 * depth[-1] - middles[-1]]])
    parts = [[edges[k], edges[k + 1], density[k]] for k in range(len(depth))]
    while len(parts) > 1:
        gaps = [_unlike(upper, lower) for upper, lower in itertools.pairwise(parts)]
        k = int(np.argmin(gaps))
        if gaps[k] > ALIKE:
            break
        (top, middle, first), (_, bottom, second) = parts[k:k + 2]
        parts[k:k + 2] = [[top, bottom, (first * (middle - top) + second * (bottom - middle)) / (bottom - top)]]
    return [Layer(round(float(top), 3), round(float(bottom), 3), density=round(float(value)))
            for top, bottom, value in parts]


def _unlike(upper, lower):
    """Difference of two densities over their mean; a fifth of it where one is too thin for a layer."""
    thinnest = min(upper[1] - upper[0], lower[1] - lower[0])
    return 2.0 * abs(lower[2] - upper[2]) / (upper[2] + lower[2]) * (0.2 if thinnest < LEAST_LAYER else 1.0)

