"""Water from ice at 0 °C."""

LATENT_HEAT = 3.334e5
"""Of melting at 0 °C and one atmosphere [J/kg]: Feistel & Wagner (2006), doi:10.1063/1.2183324."""


def melt_rate(energy_flux):
    """Water per area and time [kg/m2/s] that a flux of energy [W/m2] melts."""
    return energy_flux / LATENT_HEAT
