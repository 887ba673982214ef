"""Cohesion of flowing snow in the dry part of the friction."""

from snowmpm.compiler import ti
from snowmpm.materials.precision import larger


@ti.func
def cohesive_stress(cohesion, mu, sigma):
    """(1 - mu) C (1 - exp(-sigma/C)) [Pa], the share of the cohesion C [Pa] that a normal stress sigma [Pa] mobilises.

    It grows as (1 - mu) sigma at small stress and tends to (1 - mu) C. Without weight there is none, so that thin snow
    does not stick. The sum of mu sigma and this is not negative for any mu. After Bartelt et al. (2015), Modelling
    cohesion in snow avalanche flow, J. Glaciology, doi:10.3189/2015JoG14J126. RAMMS has cohesion since version 1.6.20,
    which vanishes with the stress, with C of 0 to 100 Pa for dry and 100 to 300 Pa for wet snow (answers to questions
    at ramms.slf.ch). Unconfirmed: the equation itself, which was not compared with the text of the paper.
    """
    ratio = sigma / larger(cohesion, 1e-20)
    # 1 - exp(-x) = tanh(x/2) (1 + exp(-x)), without a difference of nearly equal numbers
    return (1.0 - mu) * cohesion * ti.tanh(0.5 * ratio) * (1.0 + ti.exp(-ratio))
