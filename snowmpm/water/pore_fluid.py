"""The law of particles of water in pores: none, since the scheme that moves them gives their pressure."""

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

    IN_PORES = True

    update = staticmethod(unstressed)
    vector_update = staticmethod(unstressed)

    def wave_speed(self) -> float:
        """Its waves are those of the scheme that moves it [m/s]."""
        return 0.0

    def parameters(self) -> ElasticParameters:
        return ElasticParameters(0.0, 0.0)
