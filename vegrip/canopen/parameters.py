"""The parameters of a node as objects of its dictionary: read and written by SDO, checked as everywhere."""

from typing import Any

from canopen.objectdictionary import ODVariable
from canopen.sdo import SdoAbortedError

from vegrip.canopen.device import Device
from vegrip.canopen.indices import PARAMETERS, REFUSAL
from vegrip.errors import VegripError
from vegrip.runtime.handle import NodeHandle

REFUSED = 0x06090030  # value range of parameter exceeded
NOT_NOW = 0x08000022  # not because of the present device state
NOT_THERE = 0x060A0023  # resource not available
LONGEST_REASON = 120  # [characters] at 2400h


class SdoParameters:
    """Serves objects from 3000h on. Object 2400h says in one sentence why the last write was refused."""

    def __init__(self, device: Device, node: NodeHandle) -> None:
        self._device = device
        self._node = node
        device.local.add_read_callback(self._read)
        device.local.add_write_callback(self._write)

    def _read(self, index: int, subindex: int, od: ODVariable) -> Any:  # noqa: ARG002 (called by name)
        if index < PARAMETERS or index >= 0x6000:
            return None
        values = self._node.parameters()
        if od.name not in values:
            raise SdoAbortedError(NOT_THERE)
        return values[od.name]

    def _write(self, index: int, subindex: int, od: ODVariable, data: bytes) -> None:  # noqa: ARG002
        if index < PARAMETERS or index >= 0x6000:
            return
        try:
            self._node.set_parameter(od.name, od.decode_raw(bytes(data)))
        except VegripError as error:
            reason = str(error).encode("ascii", "replace")[:LONGEST_REASON]
            self._device.store(REFUSAL, 0, reason)
            raise SdoAbortedError(NOT_NOW if "cannot be changed now" in str(error) else REFUSED) from None
