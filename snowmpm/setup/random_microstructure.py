"""A synthetic microstructure of snow: ice where a Gaussian random field is above a level.

    f = G_s * w,   ice where f > l

w white noise, G_s a Gaussian of standard deviation s, periodic: the field has the correlation exp(-r² / (4 s²)). l is
chosen such that the ice has the volume fraction asked for (Teubner (1991), Europhysics Letters 14, 403, for two-phase
media from level cuts). The structure has a single length scale; real snow has several. Ice that is not
connected to the largest piece is removed, since it would float: the fraction is that of the largest piece.

    python -m snowmpm.setup.random_microstructure sample.npz --size 60 60 60 --fraction 0.33 --correlation 4 --seed 1
"""

import argparse
from pathlib import Path

import numpy as np
from scipy import ndimage

from snowmpm.draft import draft
from snowmpm.errors import InputError
from snowmpm.stages import counted

FRACTION_ERROR = 0.05
"""Largest relative error of the fraction: it jumps at levels where ice joins or leaves the largest piece."""


def random_microstructure(size, fraction, correlation, seed=1):
    """Voxels (uint8, 1 ice, 0 void) of shape `size`, (nx, nz) or (nx, ny, nz).

    fraction: volume fraction of ice = density of the snow over that of ice; correlation: s, in voxels.
    Raises InputError where no piece of that fraction reaches from the bottom to the top: in a plane below about 0.5, in
    space below about 0.15.
    """
    noise = np.random.default_rng(seed).standard_normal(size)
    field = ndimage.gaussian_filter(noise, correlation, mode="wrap")
    low, high = float(field.min()), float(field.max())
    for _ in counted(range(60), "making a microstructure", "levels"):
        level = 0.5 * (low + high)
        share = _largest_piece(field > level).mean()
        low, high = (level, high) if share > fraction else (low, level)
    ice = min((_largest_piece(field > level) for level in (low, high)), key=lambda one: abs(one.mean() - fraction))
    spans = ice[..., 0].any() and ice[..., -1].any()
    if not spans or abs(ice.mean() - fraction) > FRACTION_ERROR * fraction:
        raise InputError(f"no connected ice of volume fraction {fraction:g} from bottom to top of"
                         f" {' x '.join(map(str, size))} voxels: the nearest piece has {ice.mean():.3f}; a larger"
                         " fraction or sample, or another seed, has one")
    return ice.astype(np.uint8)


def _largest_piece(ice):
    """The largest piece of ice connected through faces of voxels."""
    labels, count = ndimage.label(ice)
    if count < 2:
        return ice
    sizes = np.bincount(labels.ravel())
    sizes[0] = 0
    return labels == sizes.argmax()


def main(arguments=None):
    """Command line: `python -m snowmpm.setup.random_microstructure`."""
    parser = argparse.ArgumentParser(description="Write a made-up microstructure of snow as a voxel image.")
    parser.add_argument("file", type=Path, help=".npz or .npy file")
    parser.add_argument("--size", type=int, nargs="+", required=True, help="voxels along x, (y,) z")
    parser.add_argument("--fraction", type=float, required=True, help="volume fraction of ice")
    parser.add_argument("--correlation", type=float, required=True, help="standard deviation of the filter [voxels]")
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args(arguments)
    voxels = random_microstructure(tuple(chosen.size), chosen.fraction, chosen.correlation, chosen.seed)
    with draft(chosen.file) as part:
        if chosen.file.suffix == ".npy":
            np.save(part, voxels)
        else:
            np.savez_compressed(part, phase=voxels)
    print(f"{chosen.file}: {' x '.join(map(str, voxels.shape))} voxels, ice {voxels.mean():.4f}")


if __name__ == "__main__":
    main()
