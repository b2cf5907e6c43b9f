"""Virtual fingertips on test benches, all put through the same protocol, in the time of the caller.

What the fingertips will feel is worked out beforehand, with none of the physics of the models.
"""

from collections.abc import Mapping, Sequence
from functools import lru_cache

import numpy as np

from vegrip.clock import NS
from vegrip.identification.recording.channels import CHANNELS
from vegrip.identification.simulate.protocol import Protocol, Segment
from vegrip.messages import NAN, FingertipState
from vegrip.virtual.bench.trial import Trial, run_trial
from vegrip.virtual.settings import FingertipSettings, HandSettings, SensorSettings, vary_fingertip

Hidden = Mapping[str, Mapping[str, float]]

LEAD_IN_S = 0.5  # [s] out of contact before the first segment


class Benches:
    """One bench per finger; pauses between episodes pass in the air.

    Args:
        fingers: their names.
        hand: whose ``tip``, scattered by ``spread``, each fingertip is, and whose sensors.
        protocol: what is done with each.
        seed: of scatter and noise.
        hidden: effects that the fingertips have beyond the plain one, see :mod:`vegrip.virtual.hidden`.

    """

    def __init__(
        self,
        fingers: Sequence[str],
        hand: HandSettings,
        protocol: Protocol,
        seed: int = 0,
        hidden: Hidden | None = None,
    ) -> None:
        self.fingers = tuple(fingers)
        rng = np.random.default_rng([seed, 0])
        self.tips = tuple(vary_fingertip(hand.tip, hand.spread, rng) for _ in self.fingers)
        self.time = 0.0  # [s]
        self.epoch = 0  # [ns] time 0 on the clock of the stamps
        self._jobs = [
            (tip, protocol, hand.sensor, seed + i, _frozen(hidden or {})) for i, tip in enumerate(self.tips)
        ]
        self._rows: list[tuple[float, str, tuple[float, ...]]] | None = None
        self._next = 0
        self.duration = LEAD_IN_S + protocol.duration
        """How long it lasts [s]."""

    @property
    def finished(self) -> bool:
        return self.time >= self.duration

    def prepare(self) -> None:
        """Work out what will be felt; takes a tenth of the duration for each finger."""
        if self._rows is None:
            rows = [
                row
                for finger, job in zip(self.fingers, self._jobs, strict=True)
                for row in _felt(finger, job)
            ]
            self._rows = sorted(rows, key=lambda row: row[0])

    def rewind(self) -> None:
        self.time, self._next = 0.0, 0

    def step(self, dt: float) -> list[FingertipState]:
        """Advance by ``dt`` [s]; return the states sampled on the way."""
        self.prepare()
        assert self._rows is not None  # noqa: S101
        self.time += dt
        states = []
        while self._next < len(self._rows) and self._rows[self._next][0] <= self.time + 1e-9:
            time, finger, values = self._rows[self._next]
            stamp = self.epoch + round(time * NS)
            seq = self._next // len(self.fingers) + 1
            states.append(FingertipState(stamp, finger, seq, **dict(zip(CHANNELS, values, strict=True))))
            self._next += 1
        return states


_Frozen = tuple[tuple[str, tuple[tuple[str, float], ...]], ...]
_Job = tuple[FingertipSettings, Protocol, SensorSettings, int, _Frozen]


def _frozen(hidden: Hidden) -> _Frozen:
    return tuple((name, tuple(sorted(values.items()))) for name, values in sorted(hidden.items()))


@lru_cache(maxsize=16)
def _trial(job: _Job) -> Trial:
    tip, protocol, sensors, seed, hidden = job
    first = next((s.depth for s in protocol.episodes[0] if s.depth is not None), 0.0)
    lead = Segment(LEAD_IN_S, depth=min(first, 0.0))
    unfrozen = {name: dict(values) for name, values in hidden}
    episode = (lead, *protocol.at_rest_between())
    return run_trial(tip, (episode,), sensors, seed, hidden=unfrozen, rings=8, spokes=16)


def _felt(finger: str, job: _Job) -> list[tuple[float, str, tuple[float, ...]]]:
    columns = _trial(job).columns
    missing = np.full(columns["t"].size, NAN)
    values = [columns.get(name, missing).tolist() for name in CHANNELS]
    return [(t, finger, row) for t, row in zip(columns["t"].tolist(), zip(*values, strict=True), strict=True)]
