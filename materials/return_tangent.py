"""How stiff a law is along an axis while it yields: more than elastic, where flow is not normal to the surface.

With elasticity C, flow r and normal f of the surface, both principal values of a strain (tension positive), the tangent
of a return to a surface that does not harden is

    C_ep = C − (C r) ⊗ (f C) / (f C r)

(e.g. de Souza Neto, Perić & Owen, Computational Methods for Plasticity (2008), section 7.4.4). Stress along an axis a
per strain along it is then a a : C_ep : a a = K + 4G/3 − (a C r a)(a f C a) / (f C r). In associated flow the product
is a square, and yielding makes every axis softer. In non-associated flow the two factors may differ in sign: extension
along the axis of the largest compression lowers p, and with it the q that friction allows, so that the stress along the
axis changes by both. On a cone of slope α whose flow keeps the volume that is K (1 + 2α/3) along the axis of triaxial
compression, 2.0 K for 37 degrees, where K + 4G/3 = 1.6 K for ν = 0.3. A wave along such an axis is faster than the
elastic one, and an explicit step must be shorter.
"""

import itertools

import numpy as np


def stiffest_over_elastic(K, G, returns):
    """Largest stress along an axis per strain along it, over all axes and over K + 4G/3: 1 or more [-].

    K, G: moduli [Pa]; returns: (flow, normal), (3,) each, of every face and edge; of an edge where two faces yield
    alike, the mean of theirs.
    """
    gains = [_gain(K, G, *np.asarray(pair, float)) for pair in returns]
    return 1.0 + float(max(gains)) / (K + 4.0 / 3.0 * G)


def _gain(K, G, flow, normal):
    """−(a C r a)(a f C a) / (f C r), the largest of all axes a.

    a C r a is linear in the squares of the components of a, which are at least 0 and sum to 1. The product of two
    linear functions is least on an edge of that triangle, or 0 within it.
    """
    bulk = K - 2.0 / 3.0 * G
    given, felt = (bulk * one.sum() + 2.0 * G * one for one in (flow, normal))
    least = 0.0
    for i, j in itertools.combinations(range(3), 2):
        a, b = given[j] - given[i], felt[j] - felt[i]
        share = np.clip(-0.5 * (a * felt[i] + b * given[i]) / (a * b), 0.0, 1.0) if a * b > 0.0 else 0.0
        least = min(least, *((given[i] + x * a) * (felt[i] + x * b) for x in (0.0, share, 1.0)))
    return -least / (bulk * flow.sum() * normal.sum() + 2.0 * G * flow @ normal)


def cone_return(slope, dilation):
    """(flow, normal) of the cone q = slope p, in triaxial compression. dilation: plastic volume per shear strain."""
    shear = np.array([0.5, 0.5, -1.0])
    return shear + dilation / 3.0, shear + slope / 3.0


def pyramid_returns(sin_phi, sin_psi):
    """(flow, normal) of a face of Mohr-Coulomb's pyramid, and of its edges of compression and extension."""
    corners = [[1.0, 0.0], [0.0, 0.0], [0.0, 1.0]], [[1.0, 0.0], [0.0, 0.5], [0.0, 0.5]], [[0.5, 0.0], [0.5, 0.0],
                                                                                       [0.0, 1.0]]
    for shares in corners:
        yield tuple(np.array(shares) @ [1.0 + sine, sine - 1.0] for sine in (sin_psi, sin_phi))
