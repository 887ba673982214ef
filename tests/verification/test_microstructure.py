"""Confined compression of the library's plane microstructure: four stages in numbers, and what they depend on."""

import numpy as np
import pytest

import snowmpm
from snowmpm.compression import stages
from snowmpm.render.compression_plot import curve_of


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


@pytest.mark.slow
def test_the_four_stages_of_confined_compression(tmp_path):
    """The cube of the library on a grid of 20 cells: elastic rise, softening, collapse, densification.

    The skeleton is far softer and weaker than ice: modulus and peak below their share of ice; after the peak bonds are
    gone, and what carries is friction of fragments; pores of 64 per cent close by 64 per cent of strain at the latest.
    """
    scene = snowmpm.load_scene("microstructure", {"solver.dx": 1.2e-4})
    run = snowmpm.run(scene, tmp_path)
    found = stages(curve_of(run))
    ice, fraction = scene.materials["ice"], 0.36
    strength = 2.0 * ice.cohesion * np.cos(np.pi / 6.0) / (1.0 - np.sin(np.pi / 6.0))  # uniaxial, 30 degrees
    assert 0.02 < found.modulus / (fraction * ice.youngs_modulus) < 0.5
    assert 0.02 < found.peak_stress / (fraction * strength) < 0.5
    assert found.peak_strain < 0.03
    assert found.softened < 0.6 * found.peak_stress
    assert found.softened < found.plateau < found.peak_stress
    assert found.peak_strain + 0.1 < found.densification < 1.0 - fraction
    assert found.end_stress > 3.0 * found.plateau
    assert found.hardening > 5.0 * found.plateau / (1.0 - fraction)
    assert run.history["unconverged"][-1] == 0
