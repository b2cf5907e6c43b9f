"""What the loop measures of itself, and the NodeStatus made from it."""

from collections.abc import Iterable, Mapping
from itertools import accumulate
from typing import Final

from vegrip.clock import NS
from vegrip.messages import Lifecycle, NodeStatus


class Schedule:
    """Ticks at ``start + i * period``.

    A tick served late is followed by the next one of the same grid; ticks whose whole period has passed are
    skipped and counted, never bunched up.
    """

    def __init__(self, period: float) -> None:
        self.period = round(period * NS)  # [ns]
        self.due = 0  # [ns]
        self.skipped = 0

    def start(self, now: int) -> None:
        self.due = now

    def take(self, now: int) -> int:
        """Serve the tick that is due and return its lateness [ns]."""
        late = now - self.due
        skipped = late // self.period
        self.skipped += skipped
        self.due += (skipped + 1) * self.period
        return late


MOST_FINGERS: Final = (
    256  # latencies and reports are kept for; a sender of made-up names must not make the table grow
)

_SUB = 5  # 2^5 linear buckets per octave: a bucket is at most 1/32 of its value wide
_OCTAVES = 35
SIZE = (_OCTAVES + 1) << _SUB
LONGEST = (1 << (_OCTAVES + _SUB)) - 1
"""Longest duration distinguished, 1100 s in nanoseconds; longer ones count as this."""


class Histogram:
    """Counts of durations [ns]. Memory is allocated once; ``add`` allocates nothing."""

    def __init__(self) -> None:
        self._counts = [0] * SIZE
        self.count = 0
        self.maximum = 0  # [ns] exact

    def add(self, duration: int, times: int = 1) -> None:
        """Count ``duration`` [ns] so many ``times``; a negative one counts as zero."""
        if duration < 0:  # comparisons, because this runs twice for every command: min and max cost more
            duration = 0
        elif duration > LONGEST:
            duration = LONGEST
        self._counts[_bucket(duration)] += times
        self.count += times
        if duration > self.maximum:  # noqa: PLR1730
            self.maximum = duration

    def percentile(self, share: float) -> float:
        """Return the duration [ns] that a ``share`` (0 .. 1) of all does not exceed; NaN when empty.

        The upper edge of the bucket is returned, so that it is never too small.
        """
        if not self.count:
            return float("nan")
        wanted = share * self.count
        for bucket, below in enumerate(accumulate(self._counts)):
            if below >= wanted and below:
                return float(min(_upper_edge(bucket), self.maximum))
        return float(self.maximum)

    @classmethod
    def sum_of(cls, parts: Iterable["Histogram"]) -> "Histogram":
        """Return a histogram of all that ``parts`` have counted."""
        total = cls()
        for part in parts:
            total._counts = [a + b for a, b in zip(total._counts, part._counts, strict=True)]
            total.count += part.count
            total.maximum = max(total.maximum, part.maximum)
        return total

    def clear(self) -> None:
        for bucket in range(SIZE):
            self._counts[bucket] = 0
        self.count = self.maximum = 0


def _bucket(duration: int) -> int:
    octave = duration.bit_length() - _SUB - 1
    if octave <= 0:
        return duration
    return (octave << _SUB) + (duration >> octave)


def _upper_edge(bucket: int) -> int:
    octave = max((bucket >> _SUB) - 1, 0)
    mantissa = bucket - (octave << _SUB)
    return ((mantissa + 1) << octave) - 1


WEIGHT: Final = 1 / 256
"""Of one command in the share of late ones: it looks back over some hundred commands."""

SLOW_SHARE, WELL_SHARE = 0.1, 0.01
"""Shares of late commands from which on reports are left out, and below which they all come again."""

SLOW_PERIOD_NS: Final = NS // 5
"""[ns] between the reports of a finger on a machine that cannot keep up."""


class ReportPace:
    """Watches how late commands are, and says which reports may follow them."""

    def __init__(self, deadline: int) -> None:
        self.lowered = 0  # how often the rate of reports was lowered
        self._late = deadline // 2  # [ns]
        self._share = 0.0
        self._is_slow = False
        self._reported: dict[str, int] = {}  # [ns] by finger, while reports are left out

    def answered(self, latency: int) -> None:
        """Take note of a command that left ``latency`` [ns] after its state had come."""
        self._share += WEIGHT * ((latency > self._late) - self._share)
        if self._is_slow and self._share < WELL_SHARE:
            self._is_slow = False
            self._reported.clear()
        elif not self._is_slow and self._share > SLOW_SHARE:
            self._is_slow = True
            self.lowered += 1

    def allows(self, finger: str, now: int) -> bool:
        """Whether what follows a command of ``finger`` at ``now`` [ns] is to be worked out."""
        if not self._is_slow:
            return True
        last = self._reported.get(finger)
        if last is not None and 0 <= now - last < SLOW_PERIOD_NS:
            return False
        if last is None and len(self._reported) >= MOST_FINGERS:
            return False
        self._reported[finger] = now
        return True


class LoopStatistics:
    """Counts since the start, and since the last status."""

    def __init__(self, deadline: int, now: int) -> None:
        self.deadline = deadline  # [ns] a state answered later than this, or a tick so late, is a miss
        self.deadline_misses = 0
        self.states = 0
        self.commands = 0
        self.states_sent = 0
        self.commands_received = 0
        self.pace = ReportPace(deadline)
        self.lateness_max = 0  # [ns] since the start
        self._before, self._recent = Histogram(), Histogram()  # the last status
        self._recent_lateness = 0
        self._since, self._inputs_then, self._outputs_then = now, 0, 0
        self._unanswered: dict[str, int] = {}  # finger: [ns] when the oldest state without a command came
        self._seq = 0

    @property
    def latency(self) -> Histogram:
        return Histogram.sum_of([self._before, self._recent])

    def state(self, finger: str, arrived: int) -> None:
        """Count a state of ``finger`` that arrived at ``arrived`` [ns]."""
        self.states += 1
        if finger in self._unanswered or len(self._unanswered) < MOST_FINGERS:
            self._unanswered.setdefault(finger, arrived)

    def command(self, finger: str, now: int) -> None:
        """Count a command that has left; its latency runs from the oldest state it answers."""
        self.commands += 1
        arrived = self._unanswered.pop(finger, None)
        if arrived is not None:
            self._answered(now - arrived)

    def answered(self, finger: str, arrived: int, now: int) -> None:
        """Count a state of ``finger`` and its command, as :meth:`state` and :meth:`command` do."""
        self.states += 1
        self.commands += 1
        oldest = self._unanswered.pop(finger, arrived) if self._unanswered else arrived
        self._answered(now - oldest)

    def batch(self, states: int, commands: int, arrived: int, now: int) -> None:
        """Count states that arrived together at ``arrived`` [ns], and commands that left at ``now``."""
        self.states += states
        self.commands += commands
        if not commands:
            return
        latency = now - arrived
        self._recent.add(latency, commands)
        self.pace.answered(latency)
        if latency > self.deadline:
            self.deadline_misses += commands

    def forget_states(self) -> None:
        self._unanswered.clear()

    def _answered(self, latency: int) -> None:
        self._recent.add(latency)
        self.pace.answered(latency)
        if latency > self.deadline:
            self.deadline_misses += 1

    def ticked(self, lateness: int) -> None:
        """Count a tick that came ``lateness`` [ns] after it was due."""
        self._recent_lateness = max(self._recent_lateness, lateness)
        self.lateness_max = max(self.lateness_max, lateness)
        if lateness > self.deadline:
            self.deadline_misses += 1

    @property
    def inputs(self) -> int:
        return self.commands_received if self.states_sent else self.states

    @property
    def outputs(self) -> int:
        return self.commands + self.states_sent

    def status(
        self, node: str, state: Lifecycle, now: int, dropped: int, rejected: Mapping[str, int]
    ) -> NodeStatus:
        """Return the status of the time since the last one, and begin the next."""
        elapsed = max(now - self._since, 1) / NS
        message = NodeStatus(
            stamp=now,
            node=node,
            seq=self._seq,
            state=state,
            rate_in=max(self.inputs - self._inputs_then, 0) / elapsed,
            rate_out=(self.outputs - self._outputs_then) / elapsed,
            latency_p50=self._recent.percentile(0.50) / 1e3,
            latency_p99=self._recent.percentile(0.99) / 1e3,
            latency_max=self._recent.maximum / 1e3 if self._recent.count else float("nan"),
            lateness_max=self._recent_lateness / 1e3,
            deadline_misses=self.deadline_misses,
            dropped=dropped,
            rejected=rejected,
        )
        self._since, self._inputs_then, self._outputs_then = now, self.inputs, self.outputs
        self._seq += 1
        self._before = self.latency
        self._recent.clear()
        self._recent_lateness = 0
        return message
