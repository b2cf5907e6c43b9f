"""What was sent last, to be read by SDO."""

from collections.abc import Mapping, Sequence
from typing import Any

from canopen.objectdictionary import ODVariable

from vegrip.canopen.connection_set import frame_base
from vegrip.canopen.device import Device
from vegrip.canopen.indices import COMMANDS, ESTIMATED, ESTIMATES, HEALTH, MARGINS, STATUS
from vegrip.messages import ContactEstimate, Message
from vegrip.transport.codec import Frame

RECORDS: Mapping[int, str] = {COMMANDS: "ForceCommand", MARGINS: "SlipMargin", HEALTH: "ModelHealth"}


class Mirror:
    """Answers reads of the mapped objects of the grasp force node, and of its estimates."""

    def __init__(self, device: Device, fingers: Sequence[str], hand: int) -> None:
        self._frames: dict[int, bytes] = {}  # identifier of the classic frame -> data
        self._estimates: dict[str, ContactEstimate] = {}
        self._fingers = list(fingers)
        self._device = device
        self._identifiers = {
            record + number: frame_base(name) + 8 * hand + number
            for record, name in RECORDS.items()
            for number in range(len(fingers))
        } | {STATUS: frame_base("NodeStatus") + 8 * hand}
        device.local.add_read_callback(self._read)

    def keep(self, message: Message | None, frames: Sequence[Frame]) -> None:
        """Remember what is sent: frames, and the message that they carry where it is known."""
        if isinstance(message, ContactEstimate):
            self._estimates[message.finger] = message
        for frame in frames:
            self._frames[frame.arbitration_id] = frame.data

    def _read(self, index: int, subindex: int, od: ODVariable) -> Any:
        if index in self._identifiers and subindex:
            return self._part(self._frames.get(self._identifiers[index]), index, subindex, len(od) // 8)
        if subindex and 0 <= index - ESTIMATES < len(self._fingers):
            return self._estimate(self._fingers[index - ESTIMATES], subindex)
        return None

    def _part(self, data: bytes | None, index: int, subindex: int, size: int) -> bytes | None:
        if data is None:
            return None
        record = self._device.local.object_dictionary[index]
        start = sum(len(record[sub]) // 8 for sub in range(1, subindex))
        return data[start : start + size]

    def _estimate(self, finger: str, subindex: int) -> float:
        which, is_std = divmod(subindex - 1, 2)
        message = self._estimates.get(finger)
        estimate = getattr(message, ESTIMATED[which]) if message is not None else None
        if estimate is None:
            return float("nan")
        return float(estimate.std if is_std else estimate.value)
