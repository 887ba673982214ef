"""What a method knows of itself beside the contract, and what stands for that where it knows nothing."""

from typing import Any

import numpy as np

from snowmpm.annotations import Floats
from snowmpm.stepping.contract import Affine, Forecasts, Method, PushesObstacles, Workload


def expected_dt(method: Method, breaking: bool = False) -> tuple[float, str]:
    """`Forecasts.expected_dt`, or the step for now."""
    return method.expected_dt(breaking) if isinstance(method, Forecasts) else method.stable_dt()


def course(method: Method, end_time: float, interval: float) -> Any:
    """`Forecasts.course`, or None."""
    return method.course(end_time, interval) if isinstance(method, Forecasts) else None


def workload(method: Method) -> Workload:
    """`Forecasts.workload`, or that of its particles and components alone."""
    if isinstance(method, Forecasts):
        return method.workload
    return Workload(method.particles.n_blocks, components=method.adapters.work())


def obstacle_totals(method: Method) -> Floats:
    """`PushesObstacles.obstacle_totals`, or those of no obstacle."""
    if isinstance(method, PushesObstacles):
        return method.obstacle_totals
    dim = method.frame.dim
    return np.zeros((0, dim + (1 if dim == 2 else 3) + 1))


def second_moment(method: Method) -> float:
    """`Affine.second_moment`, or 0."""
    return method.second_moment() if isinstance(method, Affine) else 0.0


def null_space_noise(method: Method, energy: float) -> float:
    """`Affine.null_space_noise`, or 0."""
    return method.null_space_noise(energy) if isinstance(method, Affine) else 0.0
