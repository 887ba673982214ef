"""Names of types in annotations; docstrings say shapes and units."""

import os
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

PathLike: TypeAlias = str | os.PathLike[str]
"""A file or a folder."""

Floats: TypeAlias = NDArray[np.float64]
"""Numbers in double precision."""

Numbers: TypeAlias = NDArray[Any]
"""Numbers as a file or a table holds them: of either precision, or whole."""

derived: Any = property
"""A property in place of an attribute of the base class: who reads it may not set it, which mypy would not allow."""
