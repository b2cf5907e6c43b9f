"""A finger in single precision judges as in double, and commands nearly the same."""

from collections.abc import Callable

import pytest

from tests.export.firmware import Firmware
from validation.compiled_finger import Event, Log, Replay, hostile, record
from validation.faults.table import CASES, Case
from validation.finger_in_floats import parted
from vegrip.c99 import host
from vegrip.messages import Condition, FingertipState
from vegrip.transport.codec import CanCodec

pytestmark = pytest.mark.skipif(host.compiler() is None, reason="no C compiler")
RAMP_STEP = 0.25  # [N] that the fail-safe ramp climbs from one renewed command to the next
NS = 1_000_000_000


@pytest.mark.long
def test_a_finger_takes_little_more_than_half(firmware: Callable[..., Firmware]) -> None:
    assert firmware("finger", "float")[1].ram < 5200


@pytest.mark.long
def test_the_hand_is_judged_as_in_double_and_forces_agree_within_two_millinewton() -> None:
    found = parted(record(None, 2.0, "hand"))
    assert found.commands > 1900
    assert found.judged_otherwise == 0
    assert 0.0 < found.largest < 2e-3


@pytest.mark.long
def test_hostile_states_are_judged_as_in_double() -> None:
    found = parted(hostile(record(None, 1.0, "hand"), 3))
    assert found.commands > 400
    assert found.judged_otherwise == 0
    assert found.largest < 2.0 * RAMP_STEP


@pytest.mark.parametrize("case", [case for case in CASES if not case.slow][::9], ids=lambda case: case.name)
def test_a_fault_of_the_table_is_seen_at_the_same_frame_as_in_double(case: Case) -> None:
    found = parted(record(case, 0.0))
    assert found.judged_otherwise == 0
    assert found.largest < 2.0 * RAMP_STEP


def slow_clock(seconds: int) -> Log:
    """A sender whose clock is half an hour behind and loses 150 us a second, less than is allowed."""
    log = Log(("thumb",), sender_time=True)
    sender = CanCodec(log.fingers, fd=True)
    for i in range(10 * seconds):
        now = 40 * 60 * NS + i * NS // 10
        own = now - 30 * 60 * NS - i * 15_000
        force, depth = 1.0 + 0.01 * (i % 7), 1e-4 + 1e-6 * (i % 5)
        state = FingertipState(own, "thumb", i, normal_force=force, displacement=depth)
        log.events += [Event(now, frame._replace(stamp=now)) for frame in sender.encode(state)]
    return log


def test_a_clock_that_is_far_off_and_runs_slow_is_followed_for_ever() -> None:
    seconds = 360  # a float cannot follow it, and is 50 ms late after 333 s, which is the time-out
    conditions = Replay(slow_clock(seconds), "c-float").run().conditions
    assert len(conditions) == 10 * seconds
    assert set(conditions[5:]) == {(Condition.OK,)}  # five good states end what there was before the first
