"""What the loop measures of itself, and the NodeStatus made from it."""

from collections.abc import Mapping

from vegrip.clock import NS
from vegrip.messages import Lifecycle, NodeStatus
from vegrip.runtime.histogram import Histogram
from vegrip.runtime.report_pace import ReportPace

MOST_FINGERS = 256  # latencies are kept for; a sender of made-up names must not make the table grow


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
        """How long commands took after their states, since the start."""
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
        self._recent.add_equal(latency, commands)
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
        """What the node lives on: states, or commands where it sends the states itself."""
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
