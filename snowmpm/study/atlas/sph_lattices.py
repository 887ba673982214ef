"""Entries: what sums over neighbours get wrong, on lattices of particles, without a run.

Spacing 1 (dx), h the smoothing length over dx. Waves u exp(i k.x) on a triangular lattice (the
square one has shears that no fluid bears) under the uniform stress T obey, with the "volume" form of the momentum sum
and constant V = dx^2,

    rho omega^2 u = ((lambda + mu) G G^T + mu |G|^2 I) u - 2 T sum_j V (1 - cos k.r) Hess W(r) u,
    G(k) = sum_j V grad W sin k.r

Swegle, Hicks & Attaway (1995), doi:10.1006/jcph.1995.1010: elasticity cannot hold modes that the gradient does not see,
G = 0; what they do under stress is up to the second derivative of the kernel.
"""

import functools

import numpy as np

from snowmpm.sph.smoothing import KERNELS
from snowmpm.study.atlas.entry import Entry

POISSON = 0.3
GROWS, WRONG_GRADIENT, DEEP, PUSHED = 0.02, 0.1, 0.5, 0.05
"""Limits of the entries below."""
WAVES = np.linspace(-np.pi, np.pi, 33)
SQUEEZE = 0.05
"""Compression of the pairing entry over rho c^2."""


SQUARES = np.eye(2)
TRIANGLES = np.sqrt(2.0 / np.sqrt(3.0)) * np.array([[1.0, 0.0], [0.5, 0.5 * np.sqrt(3.0)]])
"""Base vectors (rows) of the triangular lattice with an area of 1 a point, the densest and most even one."""


def _neighbours(radius, base=SQUARES):
    """Offsets (n, 2) of the lattice points within the support, but for the point itself."""
    axis = np.arange(-int(1.5 * radius) - 2, int(1.5 * radius) + 3)
    r = np.stack(np.meshgrid(axis, axis, indexing="ij"), axis=-1).reshape(-1, 2) @ base
    distance = np.linalg.norm(r, axis=1)
    return r[(distance > 0.0) & (distance < radius)]


def _gradients(kernel, r, h):
    """grad W (n, 2) at r_ij = x_i - x_j."""
    return KERNELS[kernel].slope_over_r(np.linalg.norm(r, axis=-1), KERNELS[kernel].reach * h, 2)[..., None] * r


@functools.cache
def _waves(kernel, h):
    """For every wave: eigenvalues' matrices (elastic, geometric) over c^2, each (n, 2, 2); V = rho = c = 1."""
    r, step = _neighbours(KERNELS[kernel].reach * h, TRIANGLES), 1e-5
    slope = _gradients(kernel, r, h)
    hessian = np.stack([(_gradients(kernel, r + step * axis, h) - _gradients(kernel, r - step * axis, h)) / (2 * step)
                        for axis in np.eye(2)], axis=1)
    k = np.stack(np.meshgrid(WAVES, WAVES, indexing="ij"), axis=-1).reshape(-1, 2) @ np.linalg.inv(TRIANGLES).T
    phase = k @ r.T
    G = np.sin(phase) @ slope
    shear = (1.0 - 2.0 * POISSON) / (2.0 * (1.0 - POISSON))  # mu over rho c^2
    elastic = (1.0 - shear) * G[:, :, None] * G[:, None, :] + shear * (G**2).sum(axis=1)[:, None, None] * np.eye(2)
    return elastic, 2.0 * np.einsum("kj,jab->kab", 1.0 - np.cos(phase), hessian)


def growth_rate(stress, kernel, h):
    """Fastest growth of any wave under `stress` (tension positive, over rho c^2), over c / dx."""
    elastic, geometric = _waves(kernel, h)
    squares = np.linalg.eigvalsh(elastic - stress * geometric)
    return np.sqrt(max(0.0, -squares.min()))


def pairing_rate(h, kernel):
    """The same under compression, of the smoothing length h [dx]."""
    return growth_rate(-SQUEEZE, kernel, round(h, 6))


def gradient_error(depth, h, corrected, kernel="wendland_c6"):
    """Error of the normal derivative of a linear field at a particle `depth` [dx] below a flat free surface."""
    r = _neighbours(KERNELS[kernel].reach * h)
    r = r[-r[:, 1] < depth + 1e-9]  # r = x_i - x_j, neighbours above it end at the surface
    slope = _gradients(kernel, r, h)
    found = -np.einsum("na,nb->ab", r, slope)  # sum_j V (x_j - x_i) grad W, the identity in full space
    if corrected:
        found = found @ np.linalg.inv(found)
    return abs(found[1, 1] - 1.0)


def depth_in_wall(mach, dummies, h=1.5, kernel="wendland_c6"):
    """How far a particle gets into a wall of dummy particles that it meets at `mach` of its waves [dx].

    Its stress follows from the compression that the wall gives it; dummies: "mirrored" carry its stress too, "empty"
    carry none. Units: dx, c, rho.
    """
    axis, rows = np.arange(-4, 5), np.arange(-4, 0) + 0.5
    wall = np.stack(np.meshgrid(axis, rows, indexing="ij"), axis=-1).reshape(-1, 2).astype(float)
    z, v, pressure, deepest = 3.0, -mach, 0.0, np.inf
    share = 2.0 if dummies == "mirrored" else 1.0
    dt = 0.02
    for _ in range(int(8.0 / (dt * mach))):
        slope = _gradients(kernel, np.array([0.0, z]) - wall, h)[:, 1].sum()
        v -= dt * share * pressure * slope
        pressure = max(0.0, pressure + dt * v * slope)  # -div v = sum V (v_i - v_j) . grad W
        z += dt * v
        deepest = min(deepest, z)
        if v > 0.0 or z < -3.0:
            break
    return max(0.0, 0.5 - deepest)


def push_at_border(contrast, form, h, kernel="wendland_c6"):
    """Force [p / dx] on a volume of the row beside a border of densities 1 : contrast, under a pressure p all over.

    rho_i a_i = p sum_j V w_ij grad W_ij, with w = 2 of the "volume" form and rho_j / rho_i + rho_i / rho_j of that of
    "density". Layers at rest take it up by rows whose stresses lie above and below their mean by about as much, in
    turns.
    """
    r = _neighbours(KERNELS[kernel].reach * h)
    density = np.where(r[:, 1] < -0.5, contrast, 1.0)  # r = x_i - x_j, and the border is half a spacing above i
    weight = density + 1.0 / density if form == "density" else np.full(len(r), 2.0)
    return abs(weight @ _gradients(kernel, r, h)[:, 1])


def stretching_unseen(growth, h, follows, kernel="wendland_c6"):
    """Share of a rate of volume that a plain sum misses on a lattice whose volumes have grown to `growth`, spacing and
    all; follows: the smoothing length with them."""
    spacing = np.sqrt(growth)
    h = h * spacing if follows else h
    r = spacing * _neighbours(KERNELS[kernel].reach * h / spacing)
    found = -growth * np.einsum("na,na->", r, _gradients(kernel, r, h)) / 2.0
    known = KERNELS[kernel].lattice_moment(KERNELS[kernel].reach * h / (spacing if follows else 1.0), 2)
    return abs(found / known - 1.0)


ENTRIES = (
    Entry(
        name="sph_tensile", title="SPH: tensile instability",
        scene="A lattice of particles under uniform tension, every wave on it",
        seen="Particles clump and cracks open where the material holds",
        cure="solver.sph.disorder_damping = 0.5 (default) or artificial_stress = 0.5, which are left out here",
        parameter="tension over rho c^2",
        unit="", values=(1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1),
        settings={"cubic spline 1.2": {"kernel": "cubic_spline", "h": 1.2},
                  "cubic spline 1.5": {"kernel": "cubic_spline", "h": 1.5},
                  "wendland c2 1.5": {"kernel": "wendland_c2", "h": 1.5},
                  "wendland c6 1.5": {"kernel": "wendland_c6", "h": 1.5},
                  "wendland c6 2": {"kernel": "wendland_c6", "h": 2.0}},
        symptom="growth rate over c / dx", limit=GROWS, measure=growth_rate, shown="wendland c6 1.5"),
    Entry(
        name="sph_pairing", title="SPH: pairing under compression",
        scene="A lattice of particles under a compression of 0.05 rho c^2, every wave on it",
        seen="Neighbours fall onto each other by twos, and resolution is lost",
        cure='solver.sph.kernel = "wendland_c6" or "wendland_c4"; a smoothing length below the border',
        parameter="smoothing length over dx", unit="",
        values=(1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.8, 2.0, 2.2, 2.5, 3.0),
        settings={name.replace("_", " "): {"kernel": name} for name in KERNELS},
        symptom="growth rate over c / dx", limit=GROWS, measure=pairing_rate, shown="cubic spline",
        cured="wendland c6"),
    Entry(
        name="sph_free_surface", title="SPH: gradients at a free surface",
        scene="A linear field on a lattice that ends at a flat surface",
        seen="Half of the neighbours are missing, and so is up to half of the normal derivative",
        cure='solver.sph.gradient = "corrected"', parameter="depth below the surface", unit="dx",
        values=(0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0), fails="below",
        settings={"plain 1.2": {"h": 1.2, "corrected": False}, "plain 1.5": {"h": 1.5, "corrected": False},
                  "plain 2": {"h": 2.0, "corrected": False}, "corrected 1.5": {"h": 1.5, "corrected": True}},
        symptom="error of the normal derivative", limit=WRONG_GRADIENT, measure=gradient_error, shown="plain 1.5",
        cured="corrected 1.5"),
    Entry(
        name="sph_wall", title="SPH: particles that enter a wall",
        scene="A particle that meets a wall of dummy particles alone",
        seen="It gets half a spacing deep before its own compression stops it, or right through",
        cure="solver.sph.barrier = true (default); a speed below the border, or a stiffer material",
        parameter="speed over that of waves", unit="", values=(0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.6, 0.8, 1.0, 1.5),
        settings={"mirrored": {"dummies": "mirrored"}, "empty": {"dummies": "empty"}},
        symptom="depth in the wall [dx]", limit=DEEP, measure=depth_in_wall, shown="empty", cured="mirrored"),
    Entry(
        name="sph_layers", title="SPH: layers of unlike density push each other",
        scene="A lattice under one pressure, half of it of another density",
        seen="Rows at the border carry more and less than lies on them in turns; a weak layer near its strength yields",
        cure='solver.sph.momentum = "volume"', parameter="ratio of densities", unit="",
        values=(1.05, 1.1, 1.2, 1.5, 2.0, 3.0, 5.0, 10.0),
        settings={"density 1.2": {"form": "density", "h": 1.2}, "density 1.5": {"form": "density", "h": 1.5},
                  "density 2": {"form": "density", "h": 2.0}, "volume 1.5": {"form": "volume", "h": 1.5}},
        symptom="force on a row over p / dx", limit=PUSHED, measure=push_at_border, shown="density 1.5",
        cured="volume 1.5"),
    Entry(
        name="sph_spread", title="SPH: particles that spread apart",
        scene="A lattice that has grown to several times its volume, spacing and all, and grows on",
        seen="Few neighbours are left: sums see less of the strain, and give less force, than there is",
        cure='solver.sph.lengths = "mean"; a longer solver.sph.smoothing',
        parameter="volume over that of the start", unit="",
        values=(1.02, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7, 1.8, 1.9, 2.0),
        settings={"constant 1.2": {"h": 1.2, "follows": False}, "constant 1.5": {"h": 1.5, "follows": False},
                  "constant 2": {"h": 2.0, "follows": False}, "mean 1.5": {"h": 1.5, "follows": True}},
        symptom="share of the strain missed", limit=WRONG_GRADIENT, measure=stretching_unseen,
        shown="constant 1.5", cured="mean 1.5"),
)
