"""For how long a group of channels has repeated itself to the last bit: a live sensor has noise."""

from operator import attrgetter

from vegrip.estimator.elapsed import elapsed_time
from vegrip.messages import NAN, FingertipState
from vegrip.types import NamedNumbers

Values = tuple[float, ...]


class FrozenSignal:
    """Watches the channels ``names`` of one finger; a missing channel cannot freeze, others beside it can."""

    def __init__(self, *names: str) -> None:
        self._read = attrgetter(*names, names[0])  # at least two names give a tuple
        self._last: Values = ()
        self._since = 0  # [ns]

    def duration(self, state: FingertipState, now: int) -> int:
        """Take in ``state`` at ``now`` [ns]; return for how long [ns] nothing has moved."""
        values: Values = self._read(state)
        if not self._repeats(values):
            self._since = now
        self._last = values
        return elapsed_time(now, self._since)

    def write_to(self, memory: NamedNumbers, values: str, since: str) -> None:
        """Put what is known into the places ``values`` and ``since`` of a memory."""
        memory.section(values)[:] = self._last[:-1] if self._last else NAN
        memory[since] = self._since

    def read_from(self, memory: NamedNumbers, values: str, since: str) -> None:
        """Take what is known from where :meth:`write_to` puts it."""
        last = memory.section(values).tolist()
        self._last, self._since = (*last, last[0]), int(memory[since])

    def _repeats(self, values: Values) -> bool:
        if not self._last or values[0] != self._last[0] == self._last[0]:  # the usual case, quickly
            return False
        measured = [_comparable(value) for value in values]
        return any(value is not None for value in measured) and measured == [*map(_comparable, self._last)]


def _comparable(value: float) -> float | None:
    """NaN equals nothing, itself included."""
    return value if value == value else None  # noqa: PLR0124
