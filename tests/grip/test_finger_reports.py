"""When a finger tells what it has learned: at once, then every period, apart from the other fingers."""

from types import SimpleNamespace

import pytest

from vegrip.estimator.learning import Learned
from vegrip.grip.finger_reports import FingerReports
from vegrip.grip.settings import ControlSettings
from vegrip.messages import Estimate

MS = 1_000_000  # [ns]
LEARNED = {"K": Learned(Estimate(2.0, 0.1, True, 0.0), 1.9, valid=True, excited=3.0)}


def told(reports: FingerReports, times: list[int]) -> list[int]:
    """Return when something is told, looked at at these times [ms]."""
    return [time for time in times if list(reports.learned(LEARNED, time * MS))]


@pytest.mark.parametrize("phase", [0.0, 0.25, 0.8])
def test_what_is_learned_is_told_at_once_and_then_every_second_by_a_share_of_it_apart(phase: float) -> None:
    reports = FingerReports(SimpleNamespace(name="thumb"), ControlSettings(), phase)  # type: ignore[arg-type]
    second = 40 + round(1000 * (1.0 - phase))
    assert told(reports, list(range(40, 2900, 10))) == [40, *range(second, 2900, 1000)]


def test_a_clock_that_was_set_back_does_not_silence_what_is_learned() -> None:
    reports = FingerReports(SimpleNamespace(name="thumb"), ControlSettings(), 0.0)  # type: ignore[arg-type]
    assert told(reports, [5000, 5500, 100, 600, 1100]) == [5000, 100, 1100]
