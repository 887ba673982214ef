"""A bar thrown against a rigid wall (M9): its law, and the exact shock."""

from snowmpm.materials import Elastic

LAW = Elastic(density=250.0, youngs_modulus=3e6, poisson_ratio=0.3)
SPEEDS = {1.0: (0.99217823, 127.84835, 31962.1), 5.0: (0.96179180, 130.86196, 163577.0)}  # V: F, D [m/s], stress [Pa]
