"""The law of particles of water: none, since their pressure is that of `mixture.two_velocities`."""

from snowmpm.compiler import ti
from snowmpm.materials.elastic import Elastic, ElasticParameters
from snowmpm.materials.law import NonNegative


@ti.func
def unstressed(prm: ti.template(), h, state, A, dt):
    """No stress, and a step that turns nothing inside out."""
    return h, 0.0 * h, state, 0.0, 0


class PoreFluid(Elastic):
    """Water without stress of its own. Its mass is in the column "water" of its particles."""

    density: NonNegative = 0.0
    youngs_modulus: NonNegative = 1.0
    poisson_ratio: NonNegative = 0.0

    update = staticmethod(unstressed)
    vector_update = staticmethod(unstressed)

    def wave_speed(self) -> float:
        """Its waves are those of `mixture.two_velocities` [m/s]."""
        return 0.0

    def parameters(self) -> ElasticParameters:
        return ElasticParameters(0.0, 0.0)
