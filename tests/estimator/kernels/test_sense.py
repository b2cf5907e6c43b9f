"""The order of samples: a late one leaves the memory as if it had come in time; a clock may start anew."""

from types import ModuleType

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.grip.stages import FINGER, KERNELS

MS = 1_000_000  # [ns]
LATE = 3  # samples that it can go back
GAP, RECOVERY = 400 * MS + 1, 5


class Sense:
    """An empty memory whose filter only writes down what it takes: forces as digits, and times."""

    def __init__(self) -> None:
        self.kernels: ModuleType = KERNELS
        self.f = np.zeros(FINGER.n_reals)
        self.t = np.zeros(max(end for _, end in FINGER.sections.values()), np.int64)
        start, count = self.kernels.STATE0, self.kernels.MEASURED
        self.measured, self.multiples = self.f[start : start + count], np.arange(1.0, count + 1.0)
        assert start == self.kernels.STATE_NORMAL_FORCE
        self.t[self.kernels.CLOCK_GAP], self.t[self.kernels.CLOCK_RECOVERY] = GAP, RECOVERY

    def update(self, f: np.ndarray, dt: float, force: float, *_: float) -> None:
        """Keep the number of samples, the last force, a sum that depends on their order, and the time."""
        y = self.kernels.Y0
        if np.isfinite(force):
            assert np.array_equal(self.measured, force * self.multiples), "what came with this force"
        f[y], f[y + 1], f[y + 2] = f[y] + 1.0, force, 0.5 * f[y + 2] + force
        f[y + 3] += max(dt, 0.0)
        f[y + 4] = dt
        f[self.kernels.CHANNEL0 + self.kernels.CH_USED] = 1.0

    def feel(self, stamp: int, force: float) -> None:
        self.t[self.kernels.NEWS_STAMP], self.measured[:] = stamp, force * self.multiples
        self.kernels.assimilate(self.f, self.t)

    def number(self, name: str) -> int:
        return int(self.t[getattr(self.kernels, name)])

    @property
    def written(self) -> list[float]:
        return self.f[self.kernels.Y0 : self.kernels.Y0 + 5].tolist()


@pytest.fixture
def sense(monkeypatch: pytest.MonkeyPatch) -> Sense:
    made = Sense()
    monkeypatch.setattr(KERNELS, "update", made.update)
    return made


def force_of(stamp: int) -> float:
    return 1.0 + stamp / (7.0 * MS)


def expected_of(order: list[int]) -> tuple[list[int], int, int]:
    """Return which samples are taken, in their order, how many of them late, and how many are refused."""
    taken: list[int] = []
    late = refused = 0
    for stamp in order:
        behind = sum(one > stamp for one in taken)
        if stamp in taken or behind > min(LATE, max(len(taken) - 1, 0)):
            refused += 1
        else:
            late += behind > 0
            taken = sorted([*taken, stamp])
    return taken, late, refused


@given(ahead=st.lists(st.integers(0, 4), min_size=1, max_size=12))
def test_late_samples_take_their_place_and_those_too_late_none(ahead: list[int]) -> None:
    order = [(5 + place + step) * MS for place, step in enumerate(ahead)]
    taken, late, refused = expected_of(order)
    some, sorted_out = Sense(), Sense()
    with pytest.MonkeyPatch.context() as patch:
        for one, stamps in ((some, order), (sorted_out, taken)):
            patch.setattr(KERNELS, "update", one.update)
            one.t[KERNELS.CLOCK_RECOVERY] = 100
            for stamp in stamps:
                one.feel(stamp, force_of(stamp))
    assert some.written == pytest.approx(sorted_out.written)
    assert some.number("SAMPLE_STAMP") == taken[-1]
    assert some.number("SAMPLE_SEQ") == len(taken)
    assert some.number("SAMPLE_LATE") == late
    assert some.number("SAMPLE_REFUSED") == refused
    assert some.number("SAMPLE_OFFERED") == len(order)
    assert some.number("SAMPLE_SHOWN") == order[-1]


def test_after_five_stamps_in_a_row_that_do_not_advance_the_clock_of_the_sender_has_started_anew(
    sense: Sense,
) -> None:
    for stamp in (1000, 1002, 1004):
        sense.feel(stamp * MS, 1.0)
    for stamp in range(1, RECOVERY):
        sense.feel(stamp * MS, 2.0)
    sense.feel(1006 * MS, 3.0)  # not in a row: the count begins anew
    for stamp in range(1, RECOVERY):
        sense.feel(stamp * MS, 2.0)
    assert (sense.number("SAMPLE_FOLLOWED"), sense.written[0], sense.written[1]) == (0, 4.0, 3.0)
    assert sense.number("SAMPLE_TRUSTED") == 0
    sense.feel(9 * MS, 4.0)
    assert (sense.number("SAMPLE_FOLLOWED"), sense.written[0], sense.written[1]) == (1, 5.0, 4.0)
    assert sense.written[4] == pytest.approx(GAP / 1e9), "a gap of unknown length has passed"
    assert sense.number("SAMPLE_BACKWARDS") == 0
    assert sense.number("SAMPLE_TRUSTED") == sense.number("SAMPLE_BEGUN") == 1
    assert sense.number("SAMPLE_STAMP") == sense.number("SAMPLE_INFORMED") == 9 * MS
    sense.feel(9 * MS - GAP, 2.0)
    assert sense.written[0] == 5.0, "before that gap there is nothing to go back to"
    sense.feel(8 * MS, 2.0)
    assert sense.written[:2] == [6.0, 4.0], "and within it a late sample finds its place"


def test_a_memory_that_was_kept_goes_on_after_a_gap_of_unknown_length(sense: Sense) -> None:
    sense.t[KERNELS.SAMPLE_RESUMED] = 1
    sense.feel(3 * MS, 1.0)
    assert sense.written[4] == pytest.approx(GAP / 1e9)
    assert (sense.number("SAMPLE_RESUMED"), sense.number("SAMPLE_FOLLOWED")) == (0, 1)


def test_the_first_sample_measures_force_or_displacement_and_begins(sense: Sense) -> None:
    sense.feel(3 * MS, np.nan)
    assert (sense.written[0], sense.number("SAMPLE_BEGUN")) == (0.0, 0)
    sense.feel(4 * MS, 1.0)
    assert (sense.written[0], sense.written[4], sense.number("SAMPLE_BEGUN")) == (1.0, -1.0, 1)
    assert sense.number("SAMPLE_INFORMED") == 4 * MS
    sense.feel(5 * MS, np.nan)  # afterwards any is taken, and informs of nothing
    assert (sense.written[0], sense.written[4]) == (2.0, pytest.approx(1e-3))
    assert sense.number("SAMPLE_INFORMED") == 4 * MS
    assert KERNELS.informed_age(sense.t) == pytest.approx(1e-3)


def test_before_anything_informed_its_age_is_infinite(sense: Sense) -> None:
    assert KERNELS.informed_age(sense.t) == np.inf


@pytest.mark.parametrize(("slip", "speed"), [(1.0, 2e-3), (np.nan, 2e-3), (0.0, 0.0)])
def test_effects_feel_what_is_measured_and_noise_is_no_sliding(
    sense: Sense, slip: float, speed: float
) -> None:
    f, names = sense.f, ("TEMPERATURE", "TANGENTIAL_FORCE_X", "TANGENTIAL_FORCE_Y", "SLIP_SPEED")
    felt = slice(KERNELS.EXOGENOUS0, KERNELS.EXOGENOUS0 + 6)
    f[KERNELS.STATE_SLIP], f[KERNELS.TAKEN_LOAD], f[KERNELS.TAKEN_TORQUE] = slip, 0.5, 3e-3
    for name, value in zip(names, (31.0, 0.3, 0.4, 2e-3), strict=True):
        f[getattr(KERNELS, f"STATE_{name}")] = value
    KERNELS.feel_outside(f)
    assert f[felt].tolist() == [31.0, 0.5, 3e-3, speed, 0.3, 0.4]
    f[KERNELS.TAKEN_LOAD] = f[KERNELS.TAKEN_TORQUE] = np.nan
    for name in names[:3]:
        f[getattr(KERNELS, f"STATE_{name}")] = np.inf
    KERNELS.feel_outside(f)  # what is not measured stays
    assert f[felt].tolist() == [31.0, 0.5, 3e-3, speed, 0.3, 0.4]
