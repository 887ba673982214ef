"""R9: specimens between plates against the same test at a point: triaxial and biaxial under a flexible membrane,
unconfined compression.

Shortened by 0.1 m/s, 4 m/s being the speed of waves: what a plate that starts sets swinging is 5 % of the deviator at
first, and damped. (The bearing capacity of a strip footing, 5.14 c, is in `test_locking.py`, by implicit steps.)
"""

from pathlib import Path

import numpy as np
import pytest

from snowmpm.materials import AnticrackCamClay, CohesiveCamClay, MohrCoulomb
from snowmpm.scenes import load_scene
from tests.support.specimen import compress, of_point, scene_of

SAND = {"kind": "mohr_coulomb", "density": 2000.0, "youngs_modulus": 2e6, "poisson_ratio": 0.3, "friction_angle": 30.0}
SLAB = {"density": 250.0, "poisson_ratio": 0.3}
SNOW = {
    "slab": CohesiveCamClay(**SLAB, youngs_modulus=3e6, critical_slope=1.5, cohesion=0.3, hardening=1.0, p0=30e3),
    "weak layer": AnticrackCamClay(**SLAB, youngs_modulus=5e5, critical_slope=1.0, cohesion=0.3, hardening=0.1, p0=3e3,
                                   softening=0.25),
}
PRESSURE = 5e3
PAGE = Path(__file__).parents[2] / "docs" / "membrane_test.toml"


def test_the_scene_of_the_page_is_this_one():
    page = load_scene(str(PAGE))
    ours = scene_of(SAND, "mpm", 2, PRESSURE, 0.1, page.end_time)
    for table in ("solver", "domain", "materials", "bodies", "obstacles", "forces", "initial", "damping"):
        assert getattr(page, table) == getattr(ours, table), table


@pytest.mark.slow
@pytest.mark.parametrize(("method", "dim"), [("mpm", 2), ("sph", 2), ("mpm", 3)])
def test_sand_under_a_flexible_membrane(method, dim):
    """A cell pressure of 5 kPa: it yields at sigma_1 = 3 sigma_3, in the box and in the cylinder."""
    found = compress(SAND, method, dim, PRESSURE, 0.04, 0.1)
    point = of_point(MohrCoulomb.model_validate(SAND), dim, PRESSURE, 0.04).table()
    deviator = point["stress_xx"][1] - point["stress_zz"][1]
    assert deviator[-1] == pytest.approx(2.0 * PRESSURE, rel=1e-6)
    failing = found.shortening > 0.015
    assert found.deviator[failing].mean() == pytest.approx(2.0 * PRESSURE, rel=0.03)
    # Nothing has been squeezed out or in: the volume is the point's, of elastic compression alone
    volume = point["strain_xx"][1][-1] + point["strain_yy"][1][-1] + point["strain_zz"][1][-1]
    assert found.volume[failing].mean() == pytest.approx(volume, rel=0.05)
    # The membrane holds its stress on every particle within the specimen
    stress, where = found.fields["stress"], found.fields["position"]
    inside = (np.abs(where[:, :-1] - 0.05) < 0.03).all(axis=1) & (np.abs(where[:, -1] - 0.1) < 0.06)
    for side in range(dim - 1):
        assert -stress[inside, side].mean() == pytest.approx(PRESSURE, rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["mpm", "sph"])
@pytest.mark.parametrize("name", SNOW)
def test_unconfined_compression_of_snow(name, method):
    """p and q over the volume as in Gaume's chapter, figure 5, in plane strain: the slab hardens with compaction; the
    weak layer yields, loses its bonds and swells."""
    law = SNOW[name]
    strain, speed = {"slab": (0.035, 0.4), "weak layer": (0.025, 0.2)}[name]
    found = compress(law.model_dump(exclude_none=True), method, 2, 0.0, strain, speed)
    point = of_point(law, 2, 0.0, 1.2 * strain, 800).table()
    shortening = -point["strain_zz"][1]
    late = found.shortening > 0.3 * strain

    def there(values):
        return np.interp(found.shortening[late], shortening, values)

    for name_of, values in (("p", found.p), ("q", found.q)):
        np.testing.assert_allclose(values[late].mean(), there(point[name_of][1]).mean(), rtol=0.03)
    axial = there(point["stress_xx"][1] - point["stress_zz"][1])
    assert found.deviator[late].mean() == pytest.approx(axial.mean(), rel=0.03)
    volume = there(point["strain_xx"][1] + point["strain_zz"][1])
    assert np.abs(found.volume[late] - volume).max() < 0.05 * np.abs(volume).max() + 2e-4
    grows = np.polyfit(found.shortening[late], found.volume[late], 1)[0]
    assert (grows > 0.0) == (name == "weak layer")


LAYER = {**SLAB, "youngs_modulus": 5e5, "critical_slope": 2.5, "cohesion": 0.3, "hardening": 1.0, "p0": 3e3}
"""A weak layer that compression without confinement crushes: its critical line is steeper than the path."""


@pytest.mark.slow
def test_old_and_new_law_of_one_weak_layer():
    """Figure 5c, d of Gaume's chapter: unconfined, by MPM, one layer with the cohesive law and with that of the
    anticrack. The one hardens as a point does, p and q to 3 %. The other yields at the stress of a point, drops,
    compacts, and hardens when it has; on the way the specimen loses its homogeneity, which that of the old law keeps.
    """
    strain, speed = 0.06, 0.1
    old, new = CohesiveCamClay(**LAYER), AnticrackCamClay(**LAYER, softening=0.5)
    held, fell = (compress(law.model_dump(exclude_none=True), "mpm", 2, 0.0, strain, speed, 150) for law in (old, new))
    point, brittle = (of_point(law, 2, 0.0, 1.1 * strain, 2000).table() for law in (old, new))
    late = held.shortening > 0.2 * strain
    for name, values in (("p", held.p), ("q", held.q)):
        expected = np.interp(held.shortening[late], -point["strain_zz"][1], point[name][1])
        np.testing.assert_allclose(values[late], expected, rtol=0.03)
    top = int(fell.q[fell.shortening < 0.02].argmax())
    assert fell.q[top] == pytest.approx(brittle["q"][1][-brittle["strain_zz"][1] < 0.015].max(), rel=0.05)
    least = top + int(fell.q[top:].argmin())
    print(fell.q[[top, least, -1]], fell.volume[[top, least, -1]])
    assert fell.q[least] < 0.6 * fell.q[top] and fell.q[-1] > 1.3 * fell.q[least]  # drop and densification
    assert fell.volume[least] < 1.5 * fell.volume[top] < 0.0  # collapse
    spread = [np.log(loaded.fields["J"]).std() for loaded in (held, fell)]
    print(spread)
    assert spread[1] > 3.0 * spread[0]
