"""Zones of hazard maps by the definitions of their countries."""

import numpy as np
import pytest

from snowmpm.region.zones import ZONES, zones_of

NONE = np.nan


@pytest.mark.parametrize(("periods", "peaks", "zone"), [
    ((300.0,), (NONE,), 0), ((300.0,), (29.9e3,), 1), ((300.0,), (30e3,), 2), ((100.0,), (5e3,), 1),
    ((30.0,), (500.0,), 2), ((31.0,), (500.0,), 1), ((301.0,), (90e3,), 0), ((30.0, 300.0), (NONE, 10e3), 1),
    ((30.0, 300.0), (100.0, 10e3), 2),
])
def test_switzerland(periods, peaks, zone):
    found = zones_of("switzerland", periods, [np.full((1, 1), peak) for peak in peaks], np.zeros((1, 1)))
    assert found[0, 0] == zone


@pytest.mark.parametrize(("frequency", "zone"), [(0.0, 0), (1 / 6000, 0), (1 / 5000, 0), (1 / 4000, 1), (1 / 1000, 1),
                                                 (1 / 900, 2), (1 / 100, 2), (1 / 90, 3), (0.5, 3)])
def test_norway(frequency, zone):
    assert zones_of("norway", (), [], np.full((1, 1), frequency))[0, 0] == zone


def test_every_zone_has_a_name_and_a_colour():
    for zoning in ZONES.values():
        assert len(zoning.names) == len(zoning.colours) == len(set(zoning.colours))
