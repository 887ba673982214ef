"""Fields of particles by name, with their units: those of every particle, whatever its law.

`snowmpm.particles.fields` has a reader for each name. Fields that a law derives from its state are in its OUTPUTS.
"""

UNITS = {
    "position": "m", "velocity": "m/s", "density": "kg/m3", "mass": "kg", "volume": "m3", "stress": "Pa", "p": "Pa",
    "q": "Pa", "J": "1", "material": "1", "body": "1", "id": "1", "depth": "m", "pore_pressure": "Pa", "porosity": "1",
    "saturation": "1", "liquid_water": "1", "excess_pressure": "Pa", "strain_rate": "1/s",
    "inertial_number": "1", "flow_regime": "1", "steady_solid_fraction": "1", "failure_function": "1",
}
