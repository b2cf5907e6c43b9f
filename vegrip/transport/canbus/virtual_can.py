"""A virtual CAN bus with arbitration and real frame times: ``can.Bus(interface="vegrip", channel="demo")``.

It works between processes and inside one, needs no root and no server: the first to open a channel starts its
hub (:mod:`vegrip.transport.canbus.hub`). python-can's own ``virtual`` has neither arbitration nor bit rate.
"""

import json
import select
import socket
import subprocess
import sys
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import can

from vegrip.clock import NS
from vegrip.errors import VegripError
from vegrip.host.folders import runtime_folder, socket_path
from vegrip.transport.canbus import hub_wire
from vegrip.transport.canbus.bus_events import BusLoad, ErrorState
from vegrip.transport.canbus.bus_records import ACKNOWLEDGEMENT, FD
from vegrip.transport.canbus.frame_time import FD_SIZES, KIND_FLAGS, BitTiming

HUB_TIMEOUT_S = 60.0  # [s] to find or start the hub; on a busy machine a start takes many seconds
READ_AHEAD = (
    4096  # frames looked through for the error state; as many as the bus keeps for one that does not read
)
MOST_PACKETS_AT_ONCE = 256  # taken at once; a babbling node must not keep the loop from its ticks
SEND_BUFFER = 32_768  # bytes, some eighty frames: a full bus must push back on the sender within 20 ms


class Taken(NamedTuple):
    """What was dealt with of a packet of deliveries."""

    size: int  # bytes, from the beginning
    lost: int  # frames that the numbers show to be lost
    expected: int  # number of the delivery behind them
    end: int  # [ns] of the last of them
    busy: int  # [ns] of the bus by then


LookAtPacket = Callable[[bytes, int], Taken | None]
"""Looks at a packet of deliveries, given the number of the first one if none was lost; None: leaves it."""


class VegripBus(can.BusABC):
    """One node on a virtual bus.

    Args:
        channel: name of the bus; letters, digits, ``-``, ``_``.
        bitrate: [bit/s]; the first to open a channel sets its rates, later ones that name others are refused.
        data_bitrate: [bit/s] of FD frames with bit-rate switch.
        fd: whether this node sends and receives CAN FD frames.
        receive_own_messages: whether this node receives what it sent, once it was on the bus.
        listen_only: receive everything, acknowledge nothing, send nothing.
        error_frames: whether errors on the bus are received too, as SocketCAN gives them.
        faults: what goes wrong at this node on purpose, see
            :class:`~vegrip.transport.canbus.bus_events.NodeFaults`; for tests.
        patience: for how long [s] frames may wait to be brought together: who is woken less often takes less
            of the processor. Several then come at once, and :meth:`fileno` reports the first only.
            None: they come one by one.
        can_filters: as in python-can, also later by ``set_filters``. The bus does not bring what does not
            pass; error frames always do.

    """

    def __init__(
        self,
        channel: Any = "vegrip0",
        *,
        bitrate: int | None = None,
        data_bitrate: int | None = None,
        fd: bool = False,
        receive_own_messages: bool = False,
        listen_only: bool = False,
        error_frames: bool = True,
        faults: Mapping[str, Any] | None = None,
        patience: float | None = None,
        can_filters: Sequence[Any] | None = None,
        **_: Any,
    ) -> None:
        self.channel = channel
        self.channel_info = f"virtual CAN bus {channel!r}"
        self.overruns = 0
        """Frames lost because this node did not read."""
        self.fd_refused = 0
        """CAN FD frames that came, though this node was opened for classic ones only."""
        self.error_counters = (0, 0)
        """Transmit and receive error counter, as of the last error frame."""
        self._fd = fd
        self._filtered = False  # whether the bus brings a part of the frames only
        self._listen_only, self._error_frames = listen_only, error_frames
        self._error_state = ErrorState.ACTIVE
        self._unacknowledged = False  # a frame was not acknowledged, and none of another node has come since
        self._read_ahead: deque[hub_wire.Delivery] = deque()
        self._gathers = patience is not None
        self._packets: deque[bytes] = deque()  # deliveries that came in one packet
        self._next_number = 0
        self._epoch = (
            time.time_ns() - time.monotonic_ns()
        ) / NS  # [s] python-can's time stamps count from 1970
        character = {
            "wants_own_frames": receive_own_messages,
            "listen_only": listen_only,
            "faults": dict(faults or {}),
            "patience": patience,
        }
        self._checked(can_filters)
        connection, answer = _join(str(channel), bitrate, data_bitrate, character)
        self._talk_over(connection)
        self._node: int = answer["node"]
        self.timing = BitTiming(**answer["timing"])
        self._load = BusLoad(busy=answer["busy"])
        self._can_protocol = can.CanProtocol.CAN_FD if fd else can.CanProtocol.CAN_20
        super().__init__(channel, can_filters=can_filters)

    def _talk_over(self, connection: socket.socket) -> None:
        self._socket, self._readable = connection, [connection.fileno()]

    def _apply_filters(self, filters: can.typechecking.CanFilters | None) -> None:
        pairs = self._checked(filters)
        if pairs or self._filtered:
            self._hand_over(hub_wire.pack_filters(pairs), time.monotonic() + HUB_TIMEOUT_S)
            self._filtered = bool(pairs)

    def _checked(self, filters: can.typechecking.CanFilters | None) -> list[hub_wire.Pair]:
        try:
            return hub_wire.pairs_of(filters or ())
        except (KeyError, TypeError, ValueError) as error:
            raise can.CanInitializationError(f"{self.channel_info}: {error}") from None

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Queue ``msg``; when the queue is full wait up to ``timeout`` [s] (None: not at all)."""
        self.put_requests(self._request(msg), time.monotonic() + (timeout or 0.0))

    def put(self, *frames: tuple[int, bytes, int]) -> None:
        """Queue data frames at once, ``MOST_REQUESTS`` at most: :meth:`send` without ``can.Message``."""
        now = time.monotonic_ns()
        try:
            requests = [hub_wire.pack_request(now, *frame) for frame in frames]
        except KeyError as error:
            raise can.CanOperationError(f"a frame cannot have {error} bytes of data") from None
        self.put_requests(b"".join(requests))

    def take(self, deadline: float | None) -> hub_wire.Delivery | None:
        """Return the next frame for this node, None when there is none until ``deadline`` [s, monotonic].

        What python-can's ``recv`` does, without ``can.Message`` and filters.
        """
        while not self._read_ahead:
            delivery, more = self._look()
            if delivery is not None:
                return delivery
            if not more and not self._wait_for_packet(deadline):
                return None
        return self._read_ahead.popleft()

    def offer_packet(self, timeout: float, look: LookAtPacket) -> bool | None:
        """Wait up to ``timeout`` [s] for frames that come together, and let ``look`` deal with them.

        What it leaves is received as ever. Return whether it has dealt with some; None: nothing has come.
        """
        if self._packets or self._read_ahead or not (self._gathers and self._fd):
            return False
        if timeout > 0.0 and not select.select(self._readable, (), (), timeout)[0]:
            return None
        try:
            packet = self._socket.recv(hub_wire.MAX_GATHERED_BYTES)
        except BlockingIOError:
            return None
        except OSError:
            raise self._gone() from None
        taken = look(packet, self._next_number) if packet else None
        if taken is None:
            self._packets.extend(hub_wire.split_deliveries(packet))
            return False
        self.overruns += taken.lost
        self._next_number = taken.expected
        self._load.carried(taken.end, taken.busy)
        if taken.size < len(packet):
            self._packets.extend(hub_wire.split_deliveries(packet[taken.size :]))
        return True

    def put_requests(self, requests: bytes | bytearray | memoryview, deadline: float = 0.0) -> None:
        """Queue frames that are requests already, ``MOST_REQUESTS`` at most, at once."""
        if self._listen_only:
            raise can.CanOperationError(f"{self.channel_info} was opened with listen_only: it sends nothing")
        if self._error_state is ErrorState.OFF:
            raise can.CanOperationError(
                f"{self.channel_info}: this node is bus-off after too many errors; it recovers by itself, "
                "and frames that waited are lost"
            )
        self._hand_over(requests, deadline)

    def take_packets(self) -> bytes | None:
        """Return the deliveries that have come, one behind the other and not counted yet.

        None: there is something that :meth:`take` must look at. A caller that does not understand all of
        them gives them back by :meth:`put_back`; else it counts them by :meth:`count_deliveries`.
        """
        if self._read_ahead or self._packets or not self._fd:
            return None
        packets: list[bytes] = []
        try:
            while len(packets) < MOST_PACKETS_AT_ONCE:
                packets.append(self._socket.recv(hub_wire.MAX_GATHERED_BYTES))
                if not packets[-1]:
                    break
            else:
                return b"".join(packets)
        except BlockingIOError:
            return b"".join(packets)
        except OSError:
            pass  # the bus has gone, which the next look shows
        self.put_back(b"".join(packets))
        return None

    def put_back(self, deliveries: bytes) -> None:
        if deliveries:
            self._packets.extend(hub_wire.split_deliveries(deliveries))

    def count_deliveries(self, first: int, count: int, end: int, busy: int) -> None:
        """Count deliveries in a row from number ``first``; ``end`` [ns] and ``busy`` [ns] of the last."""
        self._count(first, end, busy)
        self._next_number = (first + count) & 0xFFFFFFFF

    @property
    def state(self) -> can.BusState:
        """The error state: ACTIVE, PASSIVE (also of a node that only listens) or ERROR when it is bus-off.

        What waits to be received is looked through for news, and still received afterwards.
        """
        self._look_through()
        if self._error_state is ErrorState.OFF:
            return can.BusState.ERROR
        passive = self._listen_only or self._error_state is ErrorState.PASSIVE
        return can.BusState.PASSIVE if passive else can.BusState.ACTIVE

    @state.setter
    def state(self, new_state: can.BusState) -> None:
        raise NotImplementedError(
            f"the state of {self.channel_info} follows from its errors; for one that only listens open it "
            "with listen_only=True"
        )

    def _look_through(self) -> None:
        more = len(self._read_ahead) < READ_AHEAD
        while more:
            delivery, more = self._look()
            if delivery is not None:
                self._read_ahead.append(delivery)
                more = len(self._read_ahead) < READ_AHEAD

    def _look(self) -> tuple[hub_wire.Delivery | None, bool]:
        try:
            packet = (
                self._packets.popleft() if self._packets else self._socket.recv(hub_wire.MAX_GATHERED_BYTES)
            )
        except BlockingIOError:
            return None, False
        except OSError:
            raise self._gone() from None
        if not packet:
            raise self._gone()
        if self._gathers and not self._packets:
            packet, *rest = hub_wire.split_deliveries(packet)
            self._packets.extend(rest)
        delivery = hub_wire.unpack_delivery(packet)
        return delivery if delivery is not None and self._is_for_us(delivery) else None, True

    def _hand_over(self, packet: bytes | bytearray | memoryview, deadline: float) -> None:
        while True:
            try:
                self._socket.send(packet, socket.MSG_NOSIGNAL)
            except BlockingIOError:
                self._wait_for_room(deadline)
            except OSError:
                raise self._gone() from None
            else:
                return

    def load(self) -> float:
        """Return the share of the last second for which the bus was busy.

        Exact up to the last frame that came from others: the bus says with each how long it was busy.
        """
        return self._load.share(time.monotonic_ns())

    def fileno(self) -> int:
        return self._socket.fileno()

    def shutdown(self) -> None:
        super().shutdown()
        self._socket.close()

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        delivery = self.take(None if timeout is None else time.monotonic() + timeout)
        return (None, False) if delivery is None else (self._message(delivery), delivery.is_error)

    def _is_for_us(self, delivery: hub_wire.Delivery) -> bool:
        self._count(delivery.number, delivery.end, delivery.busy)
        if delivery.is_error:
            self._unacknowledged = self._unacknowledged or bool(delivery.identifier & ACKNOWLEDGEMENT)
            self.error_counters = delivery.data[6], delivery.data[7]
            reported = hub_wire.reported_state(delivery.identifier, delivery.data)
            self._error_state = self._error_state if reported is None else reported
            return self._error_frames
        self._unacknowledged = False
        if delivery.flags & FD and not self._fd:
            self.fd_refused += 1
            return False
        return True

    def _count(self, number: int, end: int, busy: int) -> None:
        self.overruns += (number - self._next_number) & 0xFFFFFFFF
        self._next_number = (number + 1) & 0xFFFFFFFF
        self._load.carried(end, busy)

    def _message(self, delivery: hub_wire.Delivery) -> can.Message:
        frame = delivery.frame
        return can.Message(
            timestamp=delivery.end / NS + self._epoch,
            arbitration_id=frame.identifier,
            is_extended_id=frame.extended,
            is_remote_frame=frame.is_remote,
            is_error_frame=delivery.is_error,
            is_fd=frame.fd,
            bitrate_switch=frame.has_bit_rate_switch,
            error_state_indicator=frame.is_error_passive,
            dlc=FD_SIZES[frame.code],
            data=frame.data,
            channel=self.channel,
            is_rx=delivery.is_error or delivery.node != self._node,
        )

    def _request(self, msg: can.Message) -> bytes:
        if msg.is_fd and not self._fd:
            raise can.CanOperationError(f"{self.channel_info} was opened without fd=True: no FD frames")
        if msg.is_error_frame:
            raise can.CanOperationError(f"{self.channel_info} sends no error frames")
        if msg.dlc not in FD_SIZES or (not msg.is_fd and msg.dlc > 8):
            raise can.CanOperationError(f"a frame cannot have {msg.dlc} bytes of data")
        switches, is_passive = msg.bitrate_switch, msg.error_state_indicator
        flags = KIND_FLAGS[msg.is_extended_id, msg.is_remote_frame, msg.is_fd, switches, is_passive]
        data = b"" if msg.is_remote_frame else bytes(msg.data)
        return hub_wire.pack_request(
            time.monotonic_ns(), msg.arbitration_id, data, flags, FD_SIZES.index(msg.dlc)
        )

    def _wait_for_packet(self, deadline: float | None) -> bool:
        remaining = None if deadline is None else deadline - time.monotonic()
        if remaining is not None and remaining <= 0.0:
            return False
        return bool(select.select(self._readable, [], [], remaining)[0])

    def _wait_for_room(self, deadline: float) -> None:
        remaining = deadline - time.monotonic()
        if remaining <= 0.0 or not select.select([], [self._socket], [], remaining)[1]:
            self._look_through()
            why = (
                "no other node listens, so no frame is acknowledged; start one first"
                if self._unacknowledged
                else "the bus is overloaded"
            )
            raise can.CanOperationError(f"transmit queue of {self.channel_info} is full: {why}")

    def _gone(self) -> can.CanOperationError:
        return can.CanOperationError(f"{self.channel_info} has gone; open it again")

    @staticmethod
    def _detect_available_configs() -> Sequence[can.typechecking.AutoDetectedConfig]:
        names = [path.stem for path in runtime_folder("can").glob("*.bus")]
        return [{"interface": "vegrip", "channel": name} for name in sorted(names)]


def hub_process(channel: str) -> int | None:
    """Return the number of the process that is the bus ``channel``, None when it is not known."""
    try:
        return int(socket_path("can", f"{channel}.lock").read_text(encoding="ascii"))
    except (OSError, ValueError):
        return None


def _join(
    channel: str, bitrate: int | None, data_bitrate: int | None, character: Mapping[str, Any]
) -> tuple[socket.socket, dict[str, Any]]:
    if not channel.replace("-", "").replace("_", "").isalnum():
        raise can.CanInitializationError(f"{channel!r} is no name for a bus: letters, digits, - and _ only")
    rates = {"bitrate": bitrate, "data_bitrate": data_bitrate}
    asked = {name: rate for name, rate in rates.items() if rate is not None}
    try:
        greeting = hub_wire.make_greeting({"timing": asked, "must_match_rates": bool(asked), **character})
        path = socket_path("can", f"{channel}.bus")
    except VegripError as error:
        raise can.CanInitializationError(str(error)) from None
    connection, answer = _greet(path, greeting)
    if "refused" in answer:
        connection.close()
        raise can.CanInitializationError(f"virtual CAN bus {channel!r}: {answer['refused']}")
    return connection, answer


def _greet(path: Path, greeting: bytes) -> tuple[socket.socket, dict[str, Any]]:
    deadline = time.monotonic() + HUB_TIMEOUT_S
    while time.monotonic() < deadline:
        connection = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER)
        connection.settimeout(HUB_TIMEOUT_S / 6)
        try:
            connection.connect(str(path))
            connection.send(greeting)
            if answer := connection.recv(hub_wire.MAX_PACKET_BYTES):
                connection.setblocking(False)
                return connection, json.loads(answer)
        except (ConnectionError, FileNotFoundError):
            _start_hub(path)
        except TimeoutError:
            pass  # the hub ended while we came; the next round starts another
        connection.close()
    raise can.CanInitializationError(f"the virtual CAN bus at {path} cannot be started; try another channel")


def _start_hub(path: Path) -> None:
    command = [sys.executable, "-m", "vegrip.transport.canbus.hub", str(path)]
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
    if done.returncode:
        reason = done.stderr.strip().splitlines()[-1:] or ["no reason given"]
        raise can.CanInitializationError(f"the virtual CAN bus at {path} does not start: {reason[0]}")
    time.sleep(0.01)  # when another process is starting it at this moment, give it the time to
