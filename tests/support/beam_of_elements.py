"""The notched beam of `cracked_specimens` by finite elements with cohesive springs on the ligament, at rest throughout.

Half of the beam: bilinear squares of 1 mm in plane strain, a notch without width, point loads. All unknowns but the
nodes of the ligament and the one below the load are eliminated; the opening at the tip of the notch is what is driven.
"""

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from tests.support.cracked_specimens import ARM, DEPTH, NOTCH, ROCK

SIZE, HALF = 1e-3, 0.073  # m
STIFF = 1e-3
"""Opening, over that at which no cohesion is left, up to which the springs are elastic."""


def element(law):
    """Stiffness (8, 8) of a square [Pa]; corners counterclockwise from below left, x and y of each."""
    lame = law.bulk_modulus - 2.0 / 3.0 * law.shear_modulus
    D = np.diag([2.0, 2.0, 1.0]) * law.shear_modulus
    D[:2, :2] += lame
    signs, K = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]), np.zeros((8, 8))
    for gauss in signs / np.sqrt(3.0):
        dx = 0.5 * signs[:, 0] * (1.0 + signs[:, 1] * gauss[1])
        dy = 0.5 * signs[:, 1] * (1.0 + signs[:, 0] * gauss[0])
        B = np.zeros((3, 8))
        B[0, ::2], B[1, 1::2], B[2, ::2], B[2, 1::2] = dx, dy, dy, dx
        K += 0.25 * B.T @ D @ B
    return K


def bond(opening):
    """Traction [Pa] of a crack that opens for the first time, and its slope [Pa/m]."""
    complete, first = ROCK.complete_opening, STIFF * ROCK.complete_opening
    rising = opening < first
    fading = (opening >= first) & (opening < complete)
    traction = np.where(rising, opening / first, np.where(fading, (complete - opening) / (complete - first), 0.0))
    slope = np.where(rising, 1.0 / first, np.where(fading, -1.0 / (complete - first), 0.0))
    return ROCK.strength * traction, ROCK.strength * slope


def curve(last=6.0, points=300):
    """Deflection [m] of the middle against the supports, as of the gauges of `cracked_specimens.bent`, and load [N/m],
    up to an opening at the notch of `last` times that at which no cohesion is left."""
    nx, ny = round(HALF / SIZE), round(DEPTH / SIZE)
    number = np.arange((nx + 1) * (ny + 1)).reshape(nx + 1, ny + 1)
    corners = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1).reshape(-1, 4)
    rows = (2 * corners[:, :, None] + [0, 1]).reshape(-1, 8)
    entries = np.tile(element(ROCK).ravel(), len(rows))
    K = sparse.coo_matrix((entries, (np.repeat(rows, 8, axis=1).ravel(), np.tile(rows, 8).ravel()))).tocsc()
    x, y = SIZE * np.arange(nx + 1)[:, None] + 0.0 * number, SIZE * np.arange(ny + 1) + 0.0 * number
    first = round(NOTCH / SIZE)
    ligament, loaded = 2 * number[0, first:], 2 * number[0, -1] + 1
    held = 2 * number[round(ARM / SIZE), 0] + 1
    kept = np.append(ligament, loaded)
    free = np.setdiff1d(np.arange(K.shape[0]), np.append(kept, held))
    away = splu(K[free][:, free])
    moved = -away.solve(K[free][:, kept].toarray())
    S = K[kept][:, kept].toarray() + K[kept][:, free] @ moved

    def gauge(middle, width, gap=0.0):
        near = (np.abs(x - middle) < width) & (x > gap) & (np.abs(y - DEPTH / 2) < 0.006)
        return moved[np.searchsorted(free, 2 * number[near] + 1)].mean(axis=0)

    sag = gauge(ARM, 0.006) - gauge(0.0, 0.012, 0.003)
    share = np.full(len(ligament), SIZE)
    share[[0, -1]] *= 0.5
    unknown, found = np.zeros(len(kept)), [(0.0, 0.0)]
    for tip in 0.5 * ROCK.complete_opening * last * np.linspace(0.0, 1.0, points + 1)[1:] ** 2:
        unknown[0] = tip
        for _ in range(200):
            traction, slope = bond(2.0 * unknown[:-1])
            residual = S[:-1] @ unknown + share * traction
            if np.abs(residual).max() < 1e-9 * ROCK.strength * SIZE:
                break
            tangent = S[:-1, 1:].copy()
            tangent[1:, :-1] += np.diag(share[1:] * 2.0 * slope[1:])
            unknown[1:] -= np.linalg.solve(tangent, residual)
        else:
            raise ArithmeticError(f"no balance at an opening of {2.0 * tip:g} m")
        found.append((sag @ unknown, -2.0 * S[-1] @ unknown))
    return np.array(found).T
