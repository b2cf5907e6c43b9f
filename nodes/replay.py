"""Sends a recording as if it were a hand."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

from vegrip.clock import NS
from vegrip.config import build as build_parameters
from vegrip.config import parameter
from vegrip.errors import ConfigError
from vegrip.identification.recording.data import Recording
from vegrip.identification.recording.session import merge_states, read_fingers
from vegrip.messages import FingertipState, Message
from vegrip.runtime import NodeBase, NodeContext

CATCH_UP: Final = 3
"""A sender that was late catches up this many times as fast; all at once would overrun the bus."""


@dataclass(frozen=True)
class Parameters:
    """What is played and how."""

    recording: str = parameter(doc="folder of a recording or of a session", live=False)
    finger: str = parameter("", doc="play a single recording as this finger", live=False)
    speed: float = parameter(
        1.0, unit="1", low=0.01, high=100.0, doc="1: as recorded; else every rate is wrong by it", live=False
    )
    repeat: bool = parameter(False, doc="begin again at the end")
    lead: float = parameter(0.5, unit="s", low=0.0, high=60.0, doc="silence before the first state")


class ReplayNode(NodeBase):
    """Sends each state when its time has come; stamps and counters are those of a live sender."""

    parameters: Parameters
    patience_s = 1.0  # a frame waits for room in the transmit queue: nothing of a recording is to be lost

    def __init__(
        self, name: str, parameters: Parameters, fingers: tuple[str, ...], tick_period: float = 0.002
    ) -> None:
        super().__init__(name, parameters)
        self._known = fingers
        self._stride = round(CATCH_UP * tick_period * NS)  # [ns] of the recording in one tick, at most
        self._played = 0  # [ns] until when it has been sent
        self._recordings: dict[str, Recording] = {}
        self._states: Iterator[FingertipState] = iter(())
        self._next: FingertipState | None = None
        self._first = 0  # [ns] stamp in the recording of what is sent first
        self._start: int | None = None  # [ns] when it is sent
        self._seq: dict[str, int] = {}

    def configure(self) -> None:
        """Read the recording."""
        found = read_fingers(self.parameters.recording)
        if self.parameters.finger:
            if len(found) != 1:
                raise ConfigError(
                    f"{self.name}: 'finger' renames a single recording; this one has {', '.join(found)}"
                )
            found = {self.parameters.finger: next(iter(found.values()))}
        unknown = [finger for finger in found if finger not in self._known]
        if unknown:
            raise ConfigError(
                f"{self.name}: the bus does not know {', '.join(unknown)}; "
                f"it knows {', '.join(self._known)}; rename a single recording with 'finger'"
            )
        self._recordings = found

    def activate(self) -> None:
        """Begin at the beginning."""
        self._rewind()
        self.finished = False

    def cleanup(self) -> None:
        """Forget the recording."""
        self._recordings = {}

    def on_tick(self, now: int) -> Iterable[Message]:
        """Send what is due."""
        if self._start is None:
            self._start = now + round(self.parameters.lead * NS)
            self._played = now
        self._played = min(now, self._played + self._stride)
        due: list[Message] = []
        while self._next is not None and self._when(self._next) <= self._played:
            due.append(self._live(self._next))
            self._next = next(self._states, None)
        if self._next is None and self.parameters.repeat:
            self._rewind()
        self.finished = self._next is None
        return due

    def _rewind(self) -> None:
        self._states = merge_states(self._recordings)
        self._next = next(self._states, None)
        self._first = self._next.stamp if self._next is not None else 0
        self._start = None

    def _when(self, state: FingertipState) -> int:
        """Return when ``state`` is to be sent [ns]; valid once the first tick has set the start."""
        return (self._start or 0) + round((state.stamp - self._first) / self.parameters.speed)

    def _live(self, state: FingertipState) -> FingertipState:
        seq = self._seq.get(state.finger, 0)
        self._seq[state.finger] = seq + 1
        return replace(state, stamp=self._when(state), seq=seq)


def build(settings: Mapping[str, Any], context: NodeContext) -> ReplayNode:
    """Make the node."""
    parameters = build_parameters(Parameters, settings, f"{context.name} [parameters]")
    return ReplayNode(context.name, parameters, context.fingers, context.tick_period)
