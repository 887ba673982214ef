"""Fields of particles by name, with their units: those of every particle, whatever its law.

What reads them is in `snowmpm.particles.fields`, a function for each name; what laws report of their state is in their
OUTPUTS.
"""

UNITS = {
    "position": "m", "velocity": "m/s", "density": "kg/m3", "mass": "kg", "volume": "m3", "stress": "Pa", "p": "Pa",
    "q": "Pa", "J": "1", "material": "1", "body": "1", "id": "1",
}
