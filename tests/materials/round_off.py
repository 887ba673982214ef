"""Which steps lead to a strain that a precision can represent, told apart from the laws in double precision."""

import numpy as np

EPSILON = {"f32": 6e-8, "f64": 1e-16}


def representable(f, b, precision, dimension=3):
    """Steps f (n, 3, 3) from the states b = Fe Fe^T (n, 3, 3) whose strain is more than round-off, (n,) bool.

    The entries of f b f^T carry the round-off of its largest eigenvalue. The smallest eigenvalue follows from the
    volume, where those of f and b are known; the middle one must be more than round-off. In plane strain the third axis
    is not mixed with the others, so that the volume is enough.
    """
    lost = 64.0 * EPSILON[precision]
    stretch2 = np.linalg.eigvalsh(f @ b @ f.transpose(0, 2, 1))
    volume = np.linalg.det(f) / np.linalg.norm(f, axis=2).prod(axis=1)
    start = np.linalg.det(b) / np.einsum("nii->ni", b).prod(axis=1)
    middle = dimension == 2 or stretch2[:, 1] > lost * stretch2[:, 2]
    return middle & (volume > lost) & (start > lost)
