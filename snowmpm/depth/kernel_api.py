"""What components use of the depth-averaged method: its nodes and weights, and the points where kernels contain their
functions."""

from snowmpm.depth.arrays import ColumnArrays, NodeArrays
from snowmpm.depth.column_load import ColumnLoad
from snowmpm.depth.gather import LEAST_DEPTH
from snowmpm.depth.intake import Intake
from snowmpm.depth.nodes import NODE
from snowmpm.depth.plan_grid import MARGIN, TILE
from snowmpm.depth.plan_solver import WALLS
from snowmpm.depth.smoothing import SMOOTHING
from snowmpm.depth.spline import weights
from snowmpm.depth.volumes.planes import carried, limited, surface_speed

__all__ = ["LEAST_DEPTH", "MARGIN", "NODE", "SMOOTHING", "TILE", "WALLS", "ColumnArrays", "ColumnLoad", "Intake",
           "NodeArrays", "carried", "limited", "surface_speed", "weights"]
