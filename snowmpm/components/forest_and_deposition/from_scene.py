"""The forest of a scene at places in plan."""

import numpy as np

from snowmpm.components.forest_and_deposition.declare import Forest
from snowmpm.errors import InputError
from snowmpm.ground.value import Limits, RasterValue
from snowmpm.reading.named_files import existing
from snowmpm.seeding.regions import inside_region
from snowmpm.terrain.raster_values import raster_values

NUMBERS = ("drag", "detrainment")


def forest_at(scene, surface, plan):
    """Drag [-] and detrainment [Pa] (n, 2) at plan places (n, 2) [m]; of two forests at a place, the larger numbers.

    A raster has nothing where it has no data. InputError: unreadable, a number out of range, a region off the terrain.
    """
    found = np.zeros((len(plan), len(NUMBERS)))
    for i, forest in enumerate(scene.terrain.forest):
        key = f"terrain.forest.{i}"
        try:
            numbers = np.stack([_number(forest[name], _limits(name), (scene.base_dir, f"{key}.{name}.file"),
                                        surface, plan) for name in NUMBERS], axis=1)
            if forest.region is not None:
                numbers[~inside_region(forest.region, surface, plan, scene.base_dir, f"{key}.region")] = 0.0
        except InputError as error:
            raise InputError(f"{scene.source}: {error}") from None
        found = np.maximum(found, numbers)
    return found


def _limits(name):
    return next(entry for entry in Forest.model_fields[name].metadata if isinstance(entry, Limits))


def _number(value, limits, place, surface, plan):
    if not isinstance(value, RasterValue):
        return np.full(len(plan), float(value))
    base_dir, key = place
    path = existing(value.file, base_dir, key)
    numbers = np.nan_to_num(raster_values(path, key, "numbers of forest", surface.system, plan).values)
    wrong = limits.outside(numbers)
    if wrong.any():
        x, y = plan[wrong][0]
        raise InputError.at(key, str(path), f"holds {numbers[wrong][0]:.6g} at x = {x:.10g}, y = {y:.10g}: must be"
                                            f" {limits}")
    return numbers
