"""A friction that changes with time, where slips come in an order that a law of friction imitates."""

from dataclasses import replace

import numpy as np
import pytest

from tests.identification.bench import CLEAR, PROTOCOL, recorded
from vegrip.identification.diagnosis import diagnose
from vegrip.identification.recording import Recording
from vegrip.virtual.bench.protocol import slip

LOADS = np.linspace(0.7, 1.8, 10)  # [N]
ANY_ORDER = np.random.default_rng(3).permutation(LOADS)
LATERAL = ("tangential_force_x", "tangential_force_y", "torque_z")
BY_LOAD = {"load_dependent_friction": {"exponent": 0.1, "at": 1.0}}


def slips(loads: np.ndarray, hidden: dict[str, dict[str, float]], lost: float = 0.0) -> Recording:
    """Record slips under ``loads``; ``lost``: the share of the friction that goes from begin to end."""
    episodes = [(CLEAR, *slip(float(load), 0.3, pull=2e-3, duration=0.5)[1:], CLEAR) for load in loads]
    made = recorded("slips", 0, hidden, (*PROTOCOL[:4], *episodes))
    left = 1.0 - lost * (made.t - made.t[0]) / np.ptp(made.t)
    worn = {name: made.columns[name] * left for name in LATERAL if name in made.columns}
    return replace(made, columns={**made.columns, **worn})


@pytest.mark.slow
@pytest.mark.parametrize(
    ("loads", "hidden", "lost", "verdict", "named", "sets"),
    [
        (LOADS, {}, 0.1, "ambiguous", [], [["load_dependent_friction", "friction_trend"]]),
        (ANY_ORDER, {}, 0.1, "unexplained", [], []),
        pytest.param(
            ANY_ORDER, BY_LOAD, 0.0, "named", ["load_dependent_friction"], [], marks=pytest.mark.long
        ),
    ],
)
def test_a_law_of_friction_is_named_only_where_a_trend_over_time_explains_less(
    loads, hidden, lost, verdict, named, sets
) -> None:
    found = diagnose(slips(loads, hidden, lost))
    assert (found.verdict, found.named, found.indistinguishable) == (verdict, named, sets)
    if verdict == "unexplained":
        assert found.unexplained is not None
        assert found.unexplained.variable == "time"
    assert any("friction changed with time" in doubt.text for doubt in found.doubts) is bool(sets)
