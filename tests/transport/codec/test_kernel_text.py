"""What the compiled finger step packs and unpacks is what the codec of frames reads and writes."""

import dataclasses
import inspect
from typing import Any

import numpy as np
import pytest

from tests.grip.stages import KERNELS
from vegrip.messages import (
    Channel,
    ContactEstimate,
    Estimate,
    FingertipState,
    ForceCommand,
    Message,
    Reason,
    SlipMargin,
)
from vegrip.transport.codec import CanCodec, Frame

SENT = 7_000_000_000  # [ns]
AGE = 0.25  # [s], of all estimates of a contact
NUMBERS = [0.125 + 0.5 * i for i in range(40)]  # each its own, and a single
MESSAGES: dict[str, Message] = {
    "command": ForceCommand(SENT, "index", 70_000, 2.5, -0.25, Reason.RAISE, expires=SENT + 300_000_000),
    "margin": SlipMargin(SENT, "index", 70_000, Estimate(0.5, 0.125, True, AGE), *NUMBERS[:5]),
}
for valid in range(9):  # one estimate at a time is not valid; of 8, all are
    estimates = [Estimate(NUMBERS[2 * i], NUMBERS[2 * i + 1], i != valid, AGE) for i in range(8)]
    MESSAGES[f"contact{valid}"] = ContactEstimate(
        SENT, "index", 70_000, valid % 2 == 0, Channel.FORCE | Channel.RADIUS, *estimates
    )


def arguments_of(message: Message) -> dict[str, Any]:
    """Return every value that a kernel may ask for, by the name that it has there."""
    given: dict[str, Any] = {"age": AGE, "expires": 3000}  # of 0.1 ms
    for field in dataclasses.fields(message):
        value = getattr(message, field.name)
        if isinstance(value, Estimate):
            given |= {field.name: value.value, f"{field.name}_std": value.std}
            given |= {f"{field.name}_valid": int(value.valid), f"{field.name}_age": value.age}
        elif field.name != "expires":
            given[{"normal_force": "force"}.get(field.name, field.name)] = value
    return given


@pytest.mark.parametrize("name", MESSAGES)
def test_the_codec_reads_what_the_kernels_pack(name: str) -> None:
    message, codec = MESSAGES[name], CanCodec(["thumb", "index"], fd=True, use_sender_time=True)
    parts = [one for one in vars(KERNELS) if one.startswith(f"pack_{name.rstrip('012345678')}")]
    identifiers = [frame.arbitration_id for frame in codec.encode(message)]
    got = []
    for pack, identifier in zip(sorted(parts), identifiers, strict=True):
        length = getattr(KERNELS, f"{name.rstrip('012345678').upper()}_LENGTH")
        data, function = np.full(length, 255, np.uint8), getattr(KERNELS, pack)
        given = arguments_of(message)
        function(data, *(given[one] for one in list(inspect.signature(function).parameters)[1:]))
        KERNELS.protect(data, length, identifier)
        got.append(codec.decode(Frame(identifier, data.tobytes(), True, SENT)))
    assert got[-1] == message
    assert not codec.rejected


def test_the_kernels_unpack_what_the_codec_packs() -> None:
    names = [field.name for field in dataclasses.fields(FingertipState)[3:]]
    message = FingertipState(SENT, "index", 70_000, *NUMBERS[: len(names)])
    (frame,) = CanCodec(["thumb", "index"], fd=True).encode(message)
    data, f = np.frombuffer(frame.data, np.uint8), np.zeros(2000)
    KERNELS.unpack_state(f, data)
    assert [f[getattr(KERNELS, f"STATE_{name.upper()}")] for name in names] == NUMBERS[: len(names)]
    assert KERNELS.counter_of_state(data) == 70_000
    assert KERNELS.time_of_state(data) == SENT // 1000 % 2**32
    assert KERNELS.version_of_state(data) == KERNELS.WIRE_VERSION == 1
    assert len(data) == KERNELS.STATE_LENGTH


@pytest.mark.parametrize("number", range(9))
def test_a_state_with_an_infinite_value_means_nothing(number: int) -> None:
    data = np.zeros(KERNELS.STATE_LENGTH, np.uint8)
    data[12:] = np.frombuffer(np.full(9, np.nan, np.float32).tobytes(), np.uint8)
    assert KERNELS.values_mean_something(data)
    for endless in (np.inf, -np.inf):
        data[12 + 4 * number :][:4] = np.frombuffer(np.float32(endless).tobytes(), np.uint8)
        assert not KERNELS.values_mean_something(data)
