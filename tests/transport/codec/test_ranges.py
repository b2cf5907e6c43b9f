"""What the layout cannot carry is never sent as something else."""

import math
from types import SimpleNamespace
from typing import Any

import pytest

from vegrip.messages import (
    Channel,
    Estimate,
    FingertipState,
    ForceCommand,
    Lifecycle,
    Message,
    NodeStatus,
    Reason,
    SlipMargin,
)
from vegrip.transport.codec import CanCodec, MsgpackCodec
from vegrip.transport.codec.signals import Scaled, converter

FINGERS = ("thumb",)


def through(message: Message, fd: bool) -> tuple[Message | None, CanCodec]:
    sender, receiver = (CanCodec(FINGERS, fd=fd) for _ in range(2))
    received = [receiver.decode(frame) for frame in sender.encode(message)]
    assert not receiver.rejected
    return received[-1] if received else None, sender


@pytest.mark.parametrize(("fd", "value"), [(False, 32.768), (False, -40.0), (True, 1e39), (True, math.inf)])
def test_a_measurement_out_of_range_is_sent_as_not_measured_and_counted(fd: bool, value: float) -> None:
    received, sender = through(FingertipState(0, "thumb", 0, value, 1.0), fd)
    assert math.isnan(received.normal_force)  # type: ignore[union-attr]
    assert received.tangential_force_x == 1.0  # type: ignore[union-attr]
    assert sender.clipped == {"normal_force": 1}


@pytest.mark.parametrize(("asked", "sent"), [(50.0, 32.767), (-50.0, -32.767), (1e300, 32.767)])
def test_a_command_never_exceeds_what_was_asked(asked: float, sent: float) -> None:
    received, sender = through(ForceCommand(0, "thumb", 0, asked, 0.0, Reason.RAISE, 10**7), fd=False)
    assert received.normal_force == pytest.approx(sent)  # type: ignore[union-attr]
    assert sender.clipped == {"normal_force": 1}


@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf])
def test_a_command_that_is_no_number_is_not_sent(number: float) -> None:
    command = ForceCommand(0, "thumb", 0, number, 0.0, Reason.RAISE, 10**7)
    for fd in (False, True):
        assert through(command, fd)[0] is None
    codec = MsgpackCodec()
    assert codec.encode(command) is None
    assert codec.clipped == {"normal_force": 1}


def test_a_measurement_that_is_infinite_is_left_out_of_a_payload() -> None:
    codec = MsgpackCodec()
    received = codec.decode(*(codec.encode(FingertipState(0, "thumb", 0, math.inf)) or ("", b"")), stamp=0)
    assert math.isnan(received.normal_force)  # type: ignore[union-attr]
    assert codec.clipped == {"normal_force": 1}


def test_a_finger_that_is_not_configured_is_not_sent() -> None:
    for fd in (False, True):
        codec = CanCodec(FINGERS, fd=fd)
        assert codec.encode(FingertipState(0, "index", 0)) == []
        assert codec.clipped == {"finger": 1}
    network = MsgpackCodec(fingers=FINGERS)
    assert network.encode(FingertipState(0, "index", 0)) is None
    assert network.clipped == {"finger": 1}


@pytest.mark.parametrize("bound", [-0.3751, -0.001, 0.0, 0.299, 0.3, 0.3049, 0.999])
def test_a_lower_bound_is_never_rounded_up(bound: float) -> None:
    received, _ = through(SlipMargin(0, "thumb", 0, lower_bound=bound), fd=False)
    assert bound - 0.0101 <= received.lower_bound <= bound + 1e-9  # type: ignore[union-attr]


@pytest.mark.parametrize("scale", [1e-3, 0.01, 1.0, 50.0])
def test_a_bound_from_below_that_is_beyond_its_range_is_the_end_of_it_and_one_without_end_is_not(
    scale: float,
) -> None:
    bound = Scaled(scale, -100, 100, {127: math.nan, 126: math.inf}, rounds_down=True)
    assert [bound.clip(scale * steps) for steps in (100.5, 101.0, 1e6)] == [100, 100, 100]
    assert bound.clip(-101.0 * scale) == bound.clip(math.inf) == 127  # it would promise too much


def test_a_bound_that_lacks_a_billionth_of_a_step_is_on_the_grid_and_any_other_value_is_rounded() -> None:
    bound, value = Scaled(1.0, -9, 9, {}, rounds_down=True), Scaled(1.0, -9, 9, {})
    assert [bound.write(steps) for steps in (5.0, 5.0 - 0.9e-9, 5.0 - 1.1e-9, 4.6)] == [5, 5, 4, 4]
    assert value.absent == 0
    assert [value.write(steps) for steps in (5.0 - 1.1e-9, 4.6, 4.4, 9.4, 9.6)] == [5, 5, 4, 9, None]


def test_a_required_value_beyond_a_small_range_is_its_end() -> None:
    small = Scaled(1e-3, -100, 100, {127: math.nan}, required=True)
    assert [small.clip(value) for value in (0.2, -0.2, math.nan)] == [100, -100, None]


@pytest.mark.parametrize("time", [0.0, 0.019, 0.02, 1.234, 5.06, 5.07, 3600.0])
def test_a_time_to_slip_is_never_rounded_up(time: float) -> None:
    received, _ = through(SlipMargin(0, "thumb", 0, earliest_slip=time), fd=False)
    assert min(time, 5.06) - 0.0201 <= received.earliest_slip <= time + 1e-9  # type: ignore[union-attr]


def test_a_value_on_the_grid_of_a_signal_stays_there() -> None:
    """Rounding down must not walk: what came out goes in again unchanged."""
    for step in range(-127, 128):
        value = step * 0.01
        received, _ = through(SlipMargin(0, "thumb", 0, lower_bound=value), fd=False)
        assert received.lower_bound == value  # type: ignore[union-attr]


def test_never_is_infinite_and_not_known_is_nan() -> None:
    received, _ = through(SlipMargin(0, "thumb", 0, time_to_slip=math.inf, earliest_slip=math.nan), fd=False)
    assert received.time_to_slip == math.inf  # type: ignore[union-attr]
    assert math.isnan(received.earliest_slip)  # type: ignore[union-attr]


def test_a_spread_beyond_its_range_is_unknown_and_not_small() -> None:
    from vegrip.messages import ContactEstimate

    estimate = Estimate(0.5, 1000.0, True, 0.0)
    received, _ = through(ContactEstimate(0, "thumb", 0, friction_coefficient=estimate), fd=False)
    assert received.friction_coefficient.std == math.inf  # type: ignore[union-attr]


def test_an_estimate_beyond_its_range_is_not_valid() -> None:
    from vegrip.messages import ContactEstimate

    estimate = Estimate(100.0, 0.1, True, 0.0)
    received, _ = through(ContactEstimate(0, "thumb", 0, friction_coefficient=estimate), fd=False)
    assert math.isnan(received.friction_coefficient.value)  # type: ignore[union-attr]
    assert received.friction_coefficient.valid is False  # type: ignore[union-attr]


def test_counts_stop_at_the_end_of_their_signal() -> None:
    status = NodeStatus(
        0, "grasp_force", 0, Lifecycle.ACTIVE, deadline_misses=10**12, rejected={"checksum": 10**9}
    )
    assert through(status, fd=False)[0].deadline_misses == 255  # type: ignore[union-attr]
    received, _ = through(status, fd=True)
    assert (received.deadline_misses, received.rejected) == (2**32 - 1, {"checksum": 65535})  # type: ignore[union-attr]


@pytest.mark.parametrize("maximum", [1, 7, 15])
def test_every_set_of_flags_up_to_the_largest_has_a_meaning_and_none_beyond(maximum: int) -> None:
    field: Any = SimpleNamespace(kind="flags", enumeration=Channel)
    signal: Any = SimpleNamespace(choices=None, maximum=maximum)
    made = converter(field, signal)
    for raw in range(maximum + 1):
        assert made.read(raw) == Channel(raw)
        assert made.write(Channel(raw)) == raw
    assert made.read(maximum + 1) is None
