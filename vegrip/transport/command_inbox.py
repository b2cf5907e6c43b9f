"""Force commands that wait on the virtual bus, taken and read at once."""

from collections.abc import Sequence

import numpy as np

from vegrip.transport.canbus.hub_wire import DELIVERY_AT, PLAIN_PLACES, plain_flags
from vegrip.transport.canbus.virtual_can import VegripBus
from vegrip.transport.codec.command_reader import ArrivedCommand, CommandReader, RowHead


class CommandInbox:
    """Takes commands from a bus.

    Args:
        bus: brings them.
        reader: reads them.

    """

    def __init__(self, bus: VegripBus, reader: CommandReader) -> None:
        self.bus, self._reader = bus, reader
        head = RowHead(*PLAIN_PLACES, *plain_flags(reader.length), DELIVERY_AT["data"])
        self._head = np.array(head)
        self._row = DELIVERY_AT["data"] + reader.length

    def take(self) -> Sequence[ArrivedCommand] | None:
        """Return what has come; None: something else than good commands is there, to be received."""
        packet = self.bus.take_packets()
        if not packet:
            return None if packet is None else ()
        read = None
        if len(packet) % self._row == 0:
            rows = np.frombuffer(packet, np.uint8).reshape(-1, self._row)
            read = self._reader.read_rows(rows, self._head)
        if read is None:
            self.bus.put_back(packet)
            return None
        self.bus.count_deliveries(read.first, read.rows, read.end, read.busy)
        return read.commands
