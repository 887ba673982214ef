"""Permeability of snow and grains, and its share at partial saturation."""

import numpy as np
import pytest
from pydantic import TypeAdapter, ValidationError

from snowmpm.water.permeability import Calonne, KozenyCarman, Permeability, relative_permeability


def test_kozeny_carman():
    """1 mm spheres at n = 0.4: 1e-6 0.064 / (180 0.36)."""
    law = KozenyCarman(law="kozeny_carman", grain_size=1e-3)
    assert law.of(0.4) == pytest.approx(1e-6 * 0.064 / 64.8, rel=1e-12)
    n = np.linspace(0.1, 0.9, 9)
    assert (np.diff(law.of(n)) > 0.0).all()


def test_calonne():
    """r = 0.5 mm at 300 kg/m3: 3 r² exp(-3.9) = 1.518e-8 m2."""
    law = Calonne(law="calonne", grain_size=1e-3)
    assert law.of(1.0 - 300.0 / 917.0) == pytest.approx(3.0 * 0.25e-6 * np.exp(-3.9), rel=1e-12)
    assert law.of(1.0 - 300.0 / 917.0) == pytest.approx(1.518e-8, rel=1e-3)
    # Twice the grains, four times the permeability
    assert Calonne(law="calonne", grain_size=2e-3).of(0.6) == pytest.approx(4.0 * law.of(0.6), rel=1e-12)


def test_partial_saturation():
    assert relative_permeability(1.0) == 1.0 and not relative_permeability(np.array([0.0, 0.07])).any()
    assert relative_permeability(0.535) == pytest.approx(0.125, rel=1e-12)


@pytest.mark.parametrize("value", [0.0, -1e-9, 2.0, float("nan"), "high", {"law": "calonne"}, {"law": "darcy"},
                                   {"law": "calonne", "grain_size": 0.0}, {"file": ""}, True])
def test_what_is_no_permeability(value):
    with pytest.raises(ValidationError):
        TypeAdapter(Permeability).validate_python(value)
