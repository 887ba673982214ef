"""What components use of implicit MPM: terms of its equations, what laws see of the strain, and its solvers."""

from snowmpm.implicit.balance import ROUND_OFF, Balance, Strain, Term, turned
from snowmpm.implicit.linear import Linear
from snowmpm.implicit.newton import NotConverged, Solved, solve
from snowmpm.implicit.step_solver import SMALLEST_PART, StepResult, StepSolver

__all__ = ["ROUND_OFF", "SMALLEST_PART", "Balance", "Linear", "NotConverged", "Solved", "StepResult", "StepSolver",
           "Strain", "Term", "solve", "turned"]
