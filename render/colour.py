"""From a field of a run to colours: which number of each particle, between which limits, on which map."""

from dataclasses import dataclass

import matplotlib
import numpy as np
from matplotlib.colors import LinearSegmentedColormap

from snowmpm.errors import InputError

PLAIN = "snow"  # the name that asks for no field at all
SAMPLED_FRAMES = 16
SAMPLED_PARTICLES = 50000
WORDS = {"velocity": "speed", "p": "pressure p", "q": "shear stress q", "p0": "preconsolidation p₀"}
FROM_ZERO = {"velocity", "damage", "plastic_strain", "q"}

# Lightness falls evenly from snow white: what rests looks like snow, what moves fast is dark and saturated.
SNOW_WHITE_LOW = LinearSegmentedColormap.from_list(
    "snow_white_low", ["#f6f9fd", "#fdeabf", "#fcc56c", "#f58d3e", "#e05440", "#b52c5b", "#7d1c6d"]
)


@dataclass(frozen=True)
class ColourScale:
    """Field, label, limits and map of a picture's colours. `names` for a field of few whole numbers (materials)."""

    field: str
    label: str
    units: str
    low: float
    high: float
    colormap: object
    names: tuple[str, ...] = ()

    def numbers(self, frame):
        """One number a particle from the field: itself, the length of a vector, the pressure -tr/3 of a tensor."""
        return scalar(frame.fields[self.field])

    def share(self, numbers):
        """Position of numbers on the map, in [0, 1]."""
        return np.clip((np.asarray(numbers, np.float32) - self.low) / (self.high - self.low), 0.0, 1.0)

    def table(self):
        """(256, 3) colours of the map, sRGB in [0, 1]."""
        return np.asarray(self.colormap(np.linspace(0.0, 1.0, 256)))[:, :3].astype(np.float32)

    @property
    def title(self):
        return self.label if self.units in ("", "1") else f"{self.label} [{self.units}]"


def scalar(values):
    """(n,) float32 from (n,), (n, 3) or (n, 6) values; tensors are xx, yy, zz, xy, yz, xz."""
    if values.ndim == 1:
        return values.astype(np.float32)
    if values.shape[1] == 3:
        return np.sqrt(np.einsum("ij,ij->i", values, values, dtype=np.float32))
    return -values[:, :3].sum(axis=1, dtype=np.float32) / 3.0


def choose_scale(run, field):
    """The colour scale for `field` over the whole run; None draws plain snow.

    field None: speed where the run has velocities. Raises InputError for a field that the run does not have.
    """
    if field is None:
        field = "velocity" if "velocity" in run.field_names else PLAIN
    if field == "speed":
        field = "velocity"
    if field == PLAIN or not len(run):
        return None
    if field not in run.field_names:
        raise InputError.not_in("color", field, [*run.field_names, "speed", "fracture", PLAIN], file=run.path)
    sampled = np.unique(np.linspace(0, len(run) - 1, SAMPLED_FRAMES).round().astype(int))
    values = (run.frame(int(i), [field]).fields[field] for i in sampled)
    numbers = [scalar(v[:: max(1, len(v) // SAMPLED_PARTICLES)]) for v in values]
    numbers = [n[np.isfinite(n)] for n in numbers]
    label, units = WORDS.get(field, field.replace("_", " ")), run.units.get(field, "")
    if field == "material":
        return _material_scale(run, field, np.concatenate(numbers) if numbers else np.zeros(1))
    low, high = _limits(field, numbers)
    colormap = SNOW_WHITE_LOW if low == 0.0 else matplotlib.colormaps["viridis"]
    if low < 0.0 < high and min(-low, high) > 0.2 * max(-low, high):
        high = max(-low, high)
        low, colormap = -high, matplotlib.colormaps["RdBu_r"]
    return ColourScale(field, label, units, low, high, colormap)


def _limits(field, numbers):
    """Limits that hold all but a thousandth of the numbers of any frame, rounded outwards to two figures."""
    if not any(n.size for n in numbers):
        return 0.0, 1.0
    low = min(float(np.quantile(n, 0.001)) for n in numbers if n.size)
    high = max(float(np.quantile(n, 0.999)) for n in numbers if n.size)
    if field in FROM_ZERO or 0.0 <= low < 0.2 * high:
        low = 0.0
    if high - low <= 1e-6 * max(abs(high), abs(low)):
        high = low + max(abs(low), 1.0)
    step = 10.0 ** np.floor(np.log10(high - low)) / 10.0
    return float(np.floor(low / step + 1e-6) * step), float(np.ceil(high / step - 1e-6) * step)


def _material_scale(run, field, numbers):
    materials = list(run.provenance.get("materials", []))
    highest = max(int(numbers.max(initial=0)), len(materials) - 1)
    names = [*materials, *(str(k) for k in range(len(materials), highest + 1))][: highest + 1]
    colours = ["#eef3f9", "#D55E00", "#0072B2", "#F0E442", "#009E73", "#CC79A7"]
    colours = [colours[k % len(colours)] for k in range(highest + 1)]
    colormap = LinearSegmentedColormap.from_list("materials", colours * 2 if highest == 0 else colours)
    return ColourScale(field, "material", "", 0.0, float(max(highest, 1)), colormap, tuple(names))
