"""Events made false in bursts, the same for every wire: values, counters, times, order, bits and silences."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from validation.golden.events import CHANNELS, STATE, STEPS, Event, Tape

BURST, WELL = 80, 0.4  # states at most; share of bursts in which nothing is done
SILENCES = 0.003  # share of states after which nothing comes for a while
ODD = (0.0, 1e-45, 1e38, -1e38, math.inf, -math.inf, math.nan, 3.4e38, 1.0, -1.0, 60.0, -5.0, 2.0**-149)
MS = 1_000_000  # [ns]
_SLIP, _SPEED = CHANNELS.index("slip"), CHANNELS.index("slip_speed")
Way = Callable[[Event], list[Event]]


def falsified(tape: Tape, seed: int) -> Tape:
    """Return ``tape`` with false states."""
    liars = [_Liar(np.random.default_rng((seed, number))) for number in range(len(tape.fingers))]
    rng, later, found = np.random.default_rng(seed), 0, list[Event]()
    for event in tape.events:
        if rng.random() < SILENCES:
            later += int(10 ** rng.uniform(6.0, 9.0))
        moved = replace(event, now=event.now + later, stamp=event.stamp + later, sent=event.sent + later)
        found += liars[event.finger].lies(moved) if event.kind == STATE else [moved]
    return Tape(tape.fingers, tuple(sorted(found, key=lambda event: event.now)))


class _Liar:
    """One finger."""

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng
        self._ways: tuple[Way, ...] = (
            self._odd, self._bits, self._missing, self._all_odd, self._stuck, self._frozen, self._counter,
            self._scaled, self._slip, self._no_load, self._coarse, self._clock, self._lost, self._twice,
            self._late, self._flipped, self._cut, self._old,
        )  # fmt: skip
        self._left, self._way, self._channel = 0, -1, 0
        self._held: Event | None = None
        self._before: list[Event] = []
        self._off = 0  # [ns] of the sender's clock

    def lies(self, event: Event) -> list[Event]:
        """Return what comes in place of a state."""
        if self._left <= 0:
            well = self._rng.random() < WELL
            self._way = -1 if well else int(self._rng.integers(len(self._ways)))
            self._left, self._channel = (
                int(self._rng.integers(1, BURST)),
                int(self._rng.integers(len(CHANNELS))),
            )
            self._held = None
        self._left -= 1
        event = replace(event, sent=event.sent + self._off)
        self._before = [*self._before[-20:], event]
        return [event] if self._way < 0 else self._ways[self._way](event)

    def _with(self, event: Event, channel: int, value: float) -> list[Event]:
        values = list(event.values)
        values[channel] = float(np.float32(value)) if abs(value) < 3.5e38 else value
        return [replace(event, values=tuple(values))]

    def _odd(self, event: Event) -> list[Event]:
        return self._with(event, self._channel, float(self._rng.choice(ODD)))

    def _bits(self, event: Event) -> list[Event]:
        value = float(np.frombuffer(self._rng.bytes(4), dtype=np.float32)[0])
        return self._with(event, self._channel, value)

    def _missing(self, event: Event) -> list[Event]:
        return self._with(event, self._channel, math.nan)

    def _all_odd(self, event: Event) -> list[Event]:
        values = tuple(float(np.float32(self._rng.choice(ODD))) for _ in CHANNELS)
        return [replace(event, values=values)]

    def _stuck(self, event: Event) -> list[Event]:
        self._held = self._held or event
        return self._with(event, 0, self._held.values[0])

    def _frozen(self, event: Event) -> list[Event]:
        self._held = self._held or event
        return [replace(event, values=self._held.values)]

    def _counter(self, event: Event) -> list[Event]:
        return [replace(event, seq=max(0, event.seq + int(self._rng.integers(-3, 4))))]

    def _scaled(self, event: Event) -> list[Event]:
        value = event.values[self._channel] * float(self._rng.normal(1.0, 0.3))
        step = float(STEPS[self._channel])
        return self._with(
            event, self._channel, round(value / step) * step if math.isfinite(value) else math.nan
        )

    def _slip(self, event: Event) -> list[Event]:
        speed = float(self._rng.choice([0.0, 1e-3, math.nan]))
        return self._with(self._with(event, _SLIP, 1.0)[0], _SPEED, speed)

    def _no_load(self, event: Event) -> list[Event]:
        return self._with(self._with(event, 1, math.nan)[0], 2, math.nan)

    def _coarse(self, event: Event) -> list[Event]:
        return self._with(event, 0, round(event.values[0] * 20.0) / 20.0 if event.values[0] < 1e6 else 0.0)

    def _clock(self, event: Event) -> list[Event]:
        if self._left == 0:
            self._off = int(self._rng.choice([0, 20 * MS, -20 * MS, 10_000 * MS, -10_000 * MS]))
        return [event]

    def _lost(self, event: Event) -> list[Event]:
        return [] if self._rng.random() < 0.6 else [event]

    def _twice(self, event: Event) -> list[Event]:
        return [event, replace(event, now=event.now + MS, stamp=event.stamp + MS)]

    def _late(self, event: Event) -> list[Event]:
        delay = int(self._rng.choice([0, 7, 11, 60])) * MS
        return [replace(event, now=event.now + delay, stamp=event.stamp + delay)]

    def _flipped(self, event: Event) -> list[Event]:
        return [replace(event, harm=1 + int(self._rng.integers(384)))]

    def _cut(self, event: Event) -> list[Event]:
        return (
            [replace(event, harm=-1 - int(self._rng.integers(12)))] if self._rng.random() < 0.5 else [event]
        )

    def _old(self, event: Event) -> list[Event]:
        old = self._before[0]
        return [replace(old, now=event.now, stamp=event.stamp)] if self._rng.random() < 0.5 else [event]
