"""Comparison of runs with each other and with references: profiles, stress along a line, differences, answers.

Reads run files and the scenes in them; needs no solver. `snowmpm compare` prints and draws what this package finds.
"""

from snowmpm.comparison.case import Case, open_cases
from snowmpm.comparison.profile import Profile, profile
from snowmpm.comparison.quantity import Quantity
from snowmpm.comparison.stress_line import Line, StressLine, stress_along
from snowmpm.comparison.way import Way

__all__ = ["Case", "Line", "Profile", "Quantity", "StressLine", "Way", "open_cases", "profile", "stress_along"]
