"""Classes of maps and areas, with their colours: the same in pictures, tables and QGIS."""

import math
from dataclasses import dataclass, replace

PRESSURES = (1e3, 3e3, 1e4, 3e4)
"""Peak pressures whose areas and reaches are given [Pa]; 1, 3, 10 and 30 kPa are in use in several countries."""


@dataclass(frozen=True)
class Classes:
    """limits: lower ends of all classes but the first, in the unit of the raster, ascending; the last class is open.

    colours: "#rrggbb", one more than limits; scale, unit: of the labels.
    """

    limits: tuple
    colours: tuple
    scale: float = 1.0
    unit: str = "m"

    def label(self, k):
        """Class k in words: below 1 kPa, 1 to 3 kPa, 300 kPa and above."""
        bounds = [f"{limit / self.scale:g}" for limit in self.limits]
        if k == 0:
            return f"below {bounds[0]} {self.unit}"
        if k == len(bounds):
            return f"{bounds[-1]} {self.unit} and above"
        return f"{bounds[k - 1]} to {bounds[k]} {self.unit}"


PRESSURE = Classes((1e3, 3e3, 1e4, 3e4, 1e5, 3e5), ("#fdf6c9", "#fbd34a", "#f08c2e", "#d4402f", "#a01a5c", "#5f1068",
                                                    "#150524"), 1e3, "kPa")
DEPTH = Classes((0.5, 1.0, 2.0, 4.0, 8.0), ("#d8ecf6", "#8cc4e2", "#3f8fc8", "#2457a4", "#1d2a6b", "#08030f"))
SPEED = Classes((5.0, 10.0, 20.0, 30.0, 40.0), ("#f9f9d2", "#c8e58c", "#6fc06a", "#259069", "#0a5a63", "#06213b"),
                unit="m/s")
MOMENTUM = Classes((5.0, 10.0, 25.0, 50.0, 100.0), SPEED.colours, unit="m²/s")
TIME = Classes((1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0), ("#000004", "#280b53", "#65156e", "#9f2a63", "#d44842", "#f57d15",
                                                     "#fac228", "#fcffa4"), unit="s")

GREYS = ("#f2f2f2", "#d0d0d0", "#a8a8a8", "#808080", "#585858", "#303030")
"""Of a raster that has no classes."""

DEPTHS = ("release_depth", "peak_depth", "deposit_depth", "peak_thickness", "deposit_thickness", "momentary_depth")
OF_MAP = {**dict.fromkeys(DEPTHS, DEPTH), "peak_speed": SPEED,
          "momentary_speed": SPEED, "peak_pressure": PRESSURE, "peak_momentum": MOMENTUM, "arrival_time": TIME,
          "flow_duration": TIME, "cloud_peak_pressure_experiment": PRESSURE,
          "cloud_peak_foot_pressure_experiment": PRESSURE, "cloud_peak_speed_experiment": SPEED}
"""Classes of each raster of a run, by its name."""


def classes_of(name, largest):
    """Classes of the raster `name`, None for one without. largest: value of the raster.

    Limits are fixed, so that runs are comparable; for small models they are lower by a power of ten. Times,
    whose range differs between runs, have eight equal classes of a round length.
    """
    classes = OF_MAP.get(name)
    if classes is None or not largest > 0.0:
        return classes
    if classes is TIME:
        power = 10.0 ** math.floor(math.log10(largest / 8.0))
        step = next(m * power for m in (1.0, 2.0, 5.0, 10.0) if 8.0 * m * power >= largest)
        return replace(classes, limits=tuple(round(step * limit, 9) for limit in classes.limits))
    shrink = 1.0
    while largest < shrink * classes.limits[0]:
        shrink /= 10.0
    return replace(classes, limits=tuple(float(f"{shrink * limit:.6g}") for limit in classes.limits))
