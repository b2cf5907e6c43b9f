"""Where the known physics holds its numbers are the true ones."""

import numpy as np
import pytest

from vegrip.identification.diagnosis import diagnose
from vegrip.identification.fit import fit

KINDS = ("hold", "ramp", "hold", "ramp", "hold", "ramp")
TRUE = {"K": 1.8, "p": 1.5, "c1": 0.3, "nu1": 3.0}  # of the fingertip of a few lines


@pytest.mark.slow
@pytest.mark.parametrize(
    ("given", "variable"),
    [
        ({"crack": (70.0, -0.1)}, "time"),
        ({"late": ("lag", 0.01)}, "speed"),
        ({"branches": ((0.3, 3.0), (0.1, 0.3))}, "time_in_contact"),
    ],
)
def test_the_range_in_which_the_model_holds_is_told_and_the_bias_falls_there(tip, given, variable) -> None:
    recording = tip(12, kinds=KINDS, **given)
    everywhere, holds = fit(recording).model.values, diagnose(recording).holds
    assert holds.variable == variable
    assert holds.beyond > 1.5 > holds.error
    before, after = (
        np.mean([abs(np.log(at(name) / true)) for name, true in TRUE.items()])
        for at in (lambda name: everywhere[name].value, holds.parameters.__getitem__)
    )
    assert after < 0.85 * before
