"""Elastic, frictional and hypoplastic laws of the element tests."""

from frictional_laws import SOIL

from snowmpm.materials import DruckerPrager, Elastic, Hypoplastic

ELASTIC = Elastic(density=250.0, youngs_modulus=3e6, poisson_ratio=0.3)
DP = DruckerPrager(**SOIL, friction_angle=30.0, dilation_angle=10.0, cohesion=1e4)
DP_SOFT = DruckerPrager(**SOIL, friction_angle=15.0, dilation_angle=5.0, cohesion=1e3)  # yields in the oedometer too
DP_SAND = DruckerPrager(**SOIL, friction_angle=37.0)
SAND = Hypoplastic(density=1500.0, youngs_modulus=2e7, poisson_ratio=0.2, friction_angle=35.0)
