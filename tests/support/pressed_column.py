"""Snow pressed by a piston between smooth walls (M17): the column, its laws, and the exact path."""

from snowmpm.materials import CohesiveCamClay

HEIGHT, WIDTH = 0.5, 0.2
SET_A = CohesiveCamClay(density=250.0, youngs_modulus=3e6, poisson_ratio=0.3, critical_slope=1.5, cohesion=0.3,
                        hardening=1.0, p0=30e3)
SET_C = CohesiveCamClay(density=250.0, youngs_modulus=1e6, poisson_ratio=0.3, critical_slope=1.2, cohesion=0.3,
                        hardening=0.1, p0=20e3)
EXACT = {  # x: axial Cauchy stress, p, q [Pa]
    "A": {0.01: (-36841.978, 23175.819, 19949.363), 0.02: (-53237.931, 35350.365, 25250.077)},
    "C": {0.02: (-21852.106, 14624.789, 10191.924)},
}
