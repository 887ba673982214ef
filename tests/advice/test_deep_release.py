"""`check` names a release that is deeper than snow lies."""

import pytest

from snowmpm.advice.report import advise
from snowmpm.scenes import load_scene


@pytest.mark.parametrize(("top", "named"), [(1.2, False), (8.0, True), (120.0, True)])
def test_centimetres_given_as_metres(top, named):
    advice = advise(load_scene("avalanche_depth_averaged", {"bodies.0.shape.top": top, "solver.dx": 20.0}))
    assert any("m deep in the mean" in caution.says for caution in advice.cautions) == named
