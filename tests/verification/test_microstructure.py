"""Confined compression of the library's plane microstructure: four stages in numbers, and what they depend on."""

import numpy as np
import pytest

import snowmpm


def test_the_sample_has_the_density_of_its_image():
    """Mass and volume of particles are those of the voxels, at any grid."""
    for name, fraction, volume in (("microstructure_2d", 0.65, 5e-3**2), ("microstructure", 0.36, 2.4e-3**3)):
        scene = snowmpm.load_scene(name)
        with np.load(scene.base_dir / scene.bodies[0].shape.file) as archive:
            exact = float(archive["phase"].mean())
        assert exact == pytest.approx(fraction, rel=0.02)
        for coarser in (1.0, 1.7):
            refined = snowmpm.load_scene(name, {"solver.dx": coarser * scene.solver.dx})
            mass = snowmpm.Simulation(refined).audit()["mass"]
            assert mass == pytest.approx(917.0 * exact * volume, rel=1e-6)
