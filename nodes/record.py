"""Writes everything that is on the bus to a recording, beside the loop."""

import logging
import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Final

from vegrip.clock import NS
from vegrip.config import build as build_parameters
from vegrip.config import parameter
from vegrip.identification.recording.writer import BackgroundWriter, RecordingWriter
from vegrip.messages import FingertipState, Message
from vegrip.runtime import NodeBase, NodeContext

SILENT_NS: Final = 5 * NS  # [ns] without a first state, after which that is said


@dataclass(frozen=True)
class Noise:
    """Standard deviations of the sensors, written into the recordings; 0 = not known."""

    normal_force: float = parameter(0.0, unit="N", low=0.0, doc="of each sample")
    tangential_force: float = parameter(0.0, unit="N", low=0.0, doc="of each component")
    torque_z: float = parameter(0.0, unit="N m", low=0.0, doc="of each sample")
    displacement: float = parameter(0.0, unit="m", low=0.0, doc="of each sample")
    temperature: float = parameter(0.0, unit="degC", low=0.0, doc="of each sample")
    contact_radius: float = parameter(0.0, unit="m", low=0.0, doc="of each sample")
    slip_speed: float = parameter(0.0, unit="m/s", low=0.0, doc="of each sample")


@dataclass(frozen=True)
class Parameters:
    """Where the recording goes and what is written about the hand; set before the node is configured."""

    folder: str = parameter("", doc="made by the node; empty: recordings/<UTC time>", live=False)
    radius: float = parameter(
        0.0, unit="m", low=0.0, high=1.0, doc="of the fingertips, 0: unknown", live=False
    )
    noise: Noise = parameter(Noise(), doc="of the sensors", live=False)


class RecordNode(NodeBase):
    """Hands every message to the writing thread; answers nothing."""

    wakes_on_messages = False

    parameters: Parameters

    def __init__(self, name: str, parameters: Parameters) -> None:
        super().__init__(name, parameters)
        self._recorder: BackgroundWriter | None = None
        self._waits = True  # for the first state
        self._since: int | None = None  # [ns]

    @property
    def dropped(self) -> int:
        """Messages that came faster than the disk took them."""
        return self._recorder.dropped if self._recorder is not None else 0

    def configure(self) -> None:
        """Make the folder and start the thread."""
        p = self.parameters
        folder = Path(p.folder or f"recordings/{datetime.now(UTC):%Y%m%d-%H%M%S}")
        sensors = {name: std for name, std in asdict(p.noise).items() if std > 0.0}
        self._recorder = BackgroundWriter(
            RecordingWriter(folder, radius=p.radius or math.nan, sensors=sensors)
        )

    def cleanup(self) -> None:
        """Write what is left and close the folder."""
        if self._recorder is not None:
            self._recorder.close()
            self.failure = self._recorder.writer.problem
            self._recorder = None

    def on_message(self, message: Message, now: int) -> Iterable[Message]:  # noqa: ARG002
        """Queue the message for the disk."""
        if self._recorder is not None:
            self._recorder.offer(message)
        self._waits = self._waits and not isinstance(message, FingertipState)
        return ()

    def on_tick(self, now: int) -> Iterable[Message]:
        """Say, once, that nothing comes."""
        self._since = now if self._since is None else self._since
        if self._waits and now - self._since > SILENT_NS:
            self._waits = False
            logging.getLogger(f"vegrip.{self.name}").warning(
                "no state has come for %d s, so nothing is recorded: is the hand on, and are channel and "
                "rates those of its bus?",
                SILENT_NS // NS,
            )
        return ()


def build(settings: Mapping[str, Any], context: NodeContext) -> RecordNode:
    """Make the node."""
    return RecordNode(context.name, build_parameters(Parameters, settings, f"{context.name} [parameters]"))
