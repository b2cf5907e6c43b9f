"""Softening that heals in the pauses, told from softening that stays, or said to be the one or the other."""

import pytest

from tests.identification.bench import recorded
from vegrip.identification.diagnosis import diagnose
from vegrip.virtual.bench.protocol import AIR_SEGMENT, Segment

pytestmark = pytest.mark.slow

LOSS = {"loss": 0.12, "width": 4e-4}
HEALING = {"healing_softening": {**LOSS, "rate": 0.02}}
NEVER_APART = (
    AIR_SEGMENT,
    *(
        Segment(0.5, depth=1e-3 * part)
        for part in (0.6, 0.1, 0.8, 0.1, 1.1, 0.1, 0.5, 0.1, 1.4, 0.3, 1.2, 0.1)
    ),
    Segment(0.1, depth=-1e-4),
)


@pytest.mark.parametrize(
    "hidden", [HEALING, pytest.param({"mullins_softening": LOSS}, marks=pytest.mark.long)]
)
def test_softening_is_named_as_it_heals_or_stays_in_pauses_of_20_s(hidden) -> None:
    found = diagnose(recorded("softening", 0, hidden))
    assert found.verdict == "named"
    assert found.named == [*hidden]
    if hidden == HEALING:
        assert found.model.values["nu_h"].value == pytest.approx(0.02, rel=0.1)


def test_without_a_pause_nothing_tells_whether_softening_heals() -> None:
    found = diagnose(recorded("softening", 0, HEALING, (NEVER_APART,)))
    assert found.verdict == "ambiguous"
    assert set(found.indistinguishable[0]) >= {"healing_softening", "mullins_softening"}
