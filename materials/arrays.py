"""Names of types in the annotations of the library; docstrings say shapes and units."""

from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.floating[Any]]
"""Numbers of either precision."""

Whole: TypeAlias = NDArray[np.integer[Any]]
"""Whole numbers."""

Precision: TypeAlias = Literal["f32", "f64"]
"""The float that a kernel works in."""
