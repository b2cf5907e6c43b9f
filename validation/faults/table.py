"""The faults, each with what must happen: when it is seen at the latest, as what, and when all is well again.

For every one of them also holds, and is not repeated in the rows: the true grip never falls below what it was
when the fault began, or would be without it, or the fail-safe grip, nor is it raised above the greatest of
the three; nothing slips; every message that was received is in the recording.
"""

import functools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from validation.faults import frame_faults, sensor_faults, system_faults
from validation.faults.injection import Injection
from vegrip.messages import Condition

FAULT_BEGIN_S = 2.0
"""[s] when every fault begins: the object has been lifted, the grip has settled."""

NODE_TICK_S = 0.005  # [s] of the node
TIME_OUT = 0.05  # [s] watchdog.time_out
SILENCE = TIME_OUT + 2 * NODE_TICK_S  # [s] until missing input is seen
RECOVERY_S = 0.1  # [s] five good states in a row, and some
STUCK = 13 * NODE_TICK_S  # [s] of repeats of a noisy normal force, which are too many


@dataclass(frozen=True)
class Case:
    """One row."""

    name: str
    make: Callable[[], Injection]
    duration: float  # [s]
    seen_as: frozenset[Condition]  # any of these; empty: it need not be seen
    detection: float = 0.0  # [s] at the latest
    recovery: float = RECOVERY_S  # [s] after its end until every finger is OK
    counted_as: str = ""  # name under which the node that grips must have counted it
    behaviour: str = ""
    sender_time: bool = False
    anew: float = 0.0  # by which a node that has to learn friction anew may press more than fail-safe
    relaxes: float = (
        0.0  # share of the force that relaxes while the hand holds its position without a command
    )
    slow: bool = False


def _case(name: str, make: Callable[[], Injection], duration: float, *seen: Condition, **other: Any) -> Case:
    return Case(name, make, duration, frozenset(seen), **other)


STALE, MISSING, CORRUPT = Condition.STALE, Condition.MISSING, Condition.CORRUPT
REPLAYED, FROZEN, OUT_OF_RANGE = Condition.REPLAYED, Condition.FROZEN, Condition.OUT_OF_RANGE

HELD_THEN_RAMP = "held, then fail-safe"
GOES_ON = "goes on with the rest"
UNTOUCHED = "no effect"


def _losses() -> list[Case]:
    cases = []
    for share, percent in ((0.01, 1), (0.1, 10), (1.0, 100)):
        for duration, told in ((0.01, "10 ms"), (0.1, "100 ms"), (1.0, "1 s"), (10.0, "10 s")):
            seen = (STALE,) if share == 1.0 and duration > SILENCE else ()
            cases.append(
                _case(
                    f"{percent} % of all states lost for {told}",
                    functools.partial(frame_faults.Loss, share),
                    duration,
                    *seen,
                    detection=SILENCE,
                    behaviour=HELD_THEN_RAMP if seen else GOES_ON,
                    slow=duration > 5.0,
                )
            )
    return cases


CASES: tuple[Case, ...] = (
    *_losses(),
    _case(
        "all states of one finger lost for 1 s",
        lambda: frame_faults.Loss(1.0, finger=1),
        1.0,
        STALE,
        detection=SILENCE,
        behaviour=f"that finger {HELD_THEN_RAMP}",
    ),
    _case("every state sent twice", frame_faults.Duplication, 1.0, counted_as="counter", behaviour=UNTOUCHED),
    _case(
        "every other state overtaken by the next",
        frame_faults.Reordering,
        1.0,
        counted_as="counter",
        behaviour="the late ones are refused",
    ),
    _case("states 20 ms late", lambda: frame_faults.Delay(0.02), 1.0, behaviour=UNTOUCHED),
    _case(
        "states 200 ms late",
        lambda: frame_faults.Delay(0.2),
        1.0,
        STALE,
        detection=SILENCE,
        recovery=0.2 + RECOVERY_S,
        behaviour=HELD_THEN_RAMP,
    ),
    _case(
        "one bit of every state flipped behind the bus's CRC",
        frame_faults.BitFlips,
        1.0,
        CORRUPT,
        detection=SILENCE,
        counted_as="checksum",
        behaviour=HELD_THEN_RAMP,
    ),
    _case(
        "every state cut short",
        frame_faults.Truncation,
        1.0,
        CORRUPT,
        detection=SILENCE,
        counted_as="length",
        behaviour=HELD_THEN_RAMP,
    ),
    _case(
        "old states replayed with good checksums",
        frame_faults.Replay,
        2.0,
        STALE,
        REPLAYED,
        detection=40 * NODE_TICK_S + SILENCE,
        counted_as="counter",
        behaviour=HELD_THEN_RAMP,
    ),
    _case(
        "values frozen, counter alive",
        sensor_faults.Frozen,
        2.0,
        FROZEN,
        detection=0.25 + 2 * NODE_TICK_S,
        behaviour=HELD_THEN_RAMP,
    ),
    _case(
        "normal force saturated at 70 N",
        lambda: sensor_faults.Saturated(70.0),
        1.0,
        OUT_OF_RANGE,
        detection=2 * NODE_TICK_S,
        behaviour=HELD_THEN_RAMP,
    ),
    _case(
        "normal force stuck at 2 N",
        lambda: sensor_faults.Saturated(2.0),
        3.0,
        FROZEN,
        detection=STUCK,
        behaviour=HELD_THEN_RAMP,
    ),
    _case(
        "normal force stuck at 0 N",
        lambda: sensor_faults.Saturated(0.0),
        3.0,
        FROZEN,
        detection=STUCK,
        behaviour=HELD_THEN_RAMP,
    ),
    _case(
        "normal force stuck at 10 N",
        lambda: sensor_faults.Saturated(10.0),
        3.0,
        FROZEN,
        detection=STUCK,
        behaviour=HELD_THEN_RAMP,
    ),
    _case(
        "all quantities NaN",
        sensor_faults.NotANumber,
        1.0,
        MISSING,
        detection=2 * NODE_TICK_S,
        behaviour=HELD_THEN_RAMP,
    ),
    _case(
        "normal force NaN",
        lambda: sensor_faults.NotANumber(("normal_force",)),
        1.0,
        Condition.DEGRADED,
        detection=2 * NODE_TICK_S,
        behaviour=GOES_ON,
    ),
    _case(
        "tangential force NaN",
        lambda: sensor_faults.NotANumber(("tangential_force_x", "tangential_force_y")),
        1.0,
        Condition.DEGRADED,
        detection=2 * NODE_TICK_S,
        behaviour="load unknown: " + HELD_THEN_RAMP,
    ),
    _case(
        "sensor clock jumps 10 s ahead",
        lambda: sensor_faults.SenderClockJump(10.0),
        2.0,
        REPLAYED,
        detection=2.0 + 2 * NODE_TICK_S,
        behaviour="goes on as after a gap; the jump back counts as a replay",
        sender_time=True,
    ),
    _case(
        "sensor clock jumps 10 s back",
        lambda: sensor_faults.SenderClockJump(-10.0),
        2.0,
        REPLAYED,
        STALE,
        detection=2 * NODE_TICK_S,
        behaviour="held, then goes on as after a gap",
        sender_time=True,
    ),
    _case(
        "a node babbles the most urgent identifier",
        lambda: system_faults.BabblingIdiot(0x000),
        1.0,
        STALE,
        detection=SILENCE,
        behaviour="the hand holds its position",
        relaxes=0.05,
        recovery=0.5,
    ),
    _case(
        "a node babbles an identifier below all of ours",
        lambda: system_faults.BabblingIdiot(0x7FF),
        1.0,
        counted_as="unknown_id",
        behaviour=UNTOUCHED,
    ),
    _case(
        "10 % of all frames disturbed on the bus",
        lambda: system_faults.NoisyWire(0.1),
        2.0,
        counted_as="error_frame",
        behaviour="sent again; " + UNTOUCHED,
    ),
    _case(
        "the hand is bus-off, again and again",
        lambda: system_faults.BadTransceiver("hand"),
        1.0,
        STALE,
        detection=SILENCE,
        behaviour=HELD_THEN_RAMP,
    ),
    _case(
        "the gripping node is bus-off, again and again",
        lambda: system_faults.BadTransceiver("grip"),
        1.0,
        behaviour="the hand holds its position",
        relaxes=0.05,
    ),
    _case(
        "the gripping node killed, restarted after 1 s",
        system_faults.Killed,
        1.0,
        MISSING,
        detection=2 * NODE_TICK_S,
        recovery=0.5,
        behaviour="the hand holds its position; the new node takes over its force, and may press three "
        "tenths more than the fail-safe grip, as it has to learn friction anew",
        anew=0.3,
        relaxes=0.05,
    ),
    _case(
        "CPU of the gripping node starved for 0.08 s",
        lambda: system_faults.Starved(0.08),
        0.1,
        behaviour="within the lifetime of a command: " + UNTOUCHED,
    ),
    _case(
        "CPU of the gripping node starved for 0.5 s",
        lambda: system_faults.Starved(0.5),
        0.5,
        behaviour="the hand holds its position",
        relaxes=0.05,
        recovery=0.5,
    ),
    _case("a subscriber killed", system_faults.SubscriberGone, 0.5, behaviour=UNTOUCHED),
    _case("disk full while recording", system_faults.DiskFull, 2.0, behaviour=UNTOUCHED),
)
