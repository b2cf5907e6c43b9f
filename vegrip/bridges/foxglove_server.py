"""The server that Foxglove and PlotJuggler connect to: WebSocket, subprotocol ``foxglove.sdk.v1``.

It only sends. What a client has not read is kept for it in a queue of bounded length, of which the oldest
give way: the client is warned how many, and no other client or node waits for it.
"""

import asyncio
import contextlib
import json
import logging
import os
import re
import time
from collections import Counter, deque
from collections.abc import AsyncIterator, Callable, Mapping
from dataclasses import dataclass, field
from socket import SO_SNDBUF, SOL_SOCKET
from typing import Any, Final

from websockets.asyncio.server import Server, ServerConnection, serve
from websockets.exceptions import ConnectionClosed
from websockets.typing import Subprotocol

from vegrip.bridges.foxglove_alarms import AlarmSource, LogLine
from vegrip.bridges.foxglove_channels import ALARMS, Channel, Encoding, frame
from vegrip.bridges.node_topics import NodeTopics, node_parameters
from vegrip.clock import NS
from vegrip.errors import DeviceError
from vegrip.jsonable import jsonable

SUBPROTOCOLS: Final = (Subprotocol("foxglove.sdk.v1"), Subprotocol("foxglove.websocket.v1"))
MOST_CLIENTS: Final = 16
MOST_CHANNELS: Final = 1024
QUEUE_MESSAGES: Final = 1024  # messages kept for one client: half a second of five fingers at 500 Hz
WRITE_LIMIT: Final = 65_536  # [bytes] beyond the queue that wait for the socket of one client
SOCKET_BYTES: Final = 131_072  # [bytes] of that socket; left to itself it keeps megabytes, which are old then
MOST_BYTES: Final = 65_536  # [bytes] of what a client sends
TURN_MESSAGES: Final = 256  # messages until clients get their turn
LOOK_PERIOD: Final = 1.0  # [s] between two looks at which topics there are
REPORT_PERIOD: Final = 1.0  # [s] between two warnings of one client
OWN_CLOCK: Final = 1.0  # [s] a stamp that is further from now is of the clock of another machine
ORIGINS: Final = (
    None,  # a program
    re.compile(r"(?!https?:).*"),  # an application for the desktop
    re.compile(r"https://app\.foxglove\.dev|https?://(localhost|127\.0\.0\.1|\[::1\])(:\d+)?"),
)
"""Who may connect; any web site that is open in a browser of this machine could, else."""
WARNING, ERROR = 1, 2  # levels of a status


@dataclass(eq=False)
class Client:
    """One connection: what it wants, and what waits for it."""

    connection: ServerConnection
    subscriptions: dict[int, int] = field(default_factory=dict)  # channel -> its number of it
    queue: deque[bytes] = field(default_factory=lambda: deque(maxlen=QUEUE_MESSAGES))
    ready: asyncio.Event = field(default_factory=asyncio.Event)
    advertised: int = 0  # channels
    left_out: int = 0  # messages that the queue has lost
    reported: int = 0  # of them
    report_due: float = 0.0  # [s] of the monotonic clock

    def offer(self, message: bytes) -> None:
        """Queue ``message``; the oldest gives way."""
        self.left_out += len(self.queue) == QUEUE_MESSAGES
        self.queue.append(message)
        self.ready.set()


class FoxgloveServer:
    """Channels, clients and counts; :meth:`run` serves until it is cancelled."""

    def __init__(self, source: NodeTopics, encoding: Encoding) -> None:
        self.counts: Counter[str] = Counter()
        """``sent`` and ``left_out`` messages, ``refused`` requests and ``clients``."""
        self._source, self._encoding, self._alarms = source, encoding, AlarmSource()
        self._channels: list[Channel] = [encoding.log_channel(0, ALARMS)]
        self._numbers: dict[str, int] = {ALARMS: 0}
        self._clients: set[Client] = set()
        self._changed = asyncio.Event()
        self._start = time.monotonic_ns()
        self._since_1970 = time.time_ns() - self._start

    async def run(self, host: str, port: int, announce: Callable[[int], None]) -> None:
        """Serve on ``host``; ``announce`` is given the port once clients may connect.

        Raises:
            DeviceError: the port is in use, or the address is not of this machine.

        """
        async with await self._listening(host, port) as server, asyncio.TaskGroup() as tasks:
            tasks.create_task(self._look())
            tasks.create_task(self._pass_on())
            tasks.create_task(self._watch_alarms())
            announce(server.sockets[0].getsockname()[1])

    def close(self) -> None:
        """Leave the nodes; only when :meth:`run` has ended, whose threads read."""
        self._source.rest()
        self._alarms.rest()

    async def _listening(self, host: str, port: int) -> Server:
        quiet = logging.getLogger("vegrip.bridges.websockets")
        quiet.setLevel(logging.CRITICAL)  # a connection that is no WebSocket is counted, not reported
        try:
            return await serve(
                self._attend,
                host,
                port,
                subprotocols=SUBPROTOCOLS,
                origins=ORIGINS,
                compression=None,
                max_size=MOST_BYTES,
                max_queue=4,
                write_limit=WRITE_LIMIT,
                logger=quiet,
            )
        except OSError as error:
            why = os.strerror(error.errno) if error.errno and error.errno > 0 else error
            raise DeviceError(
                f"port {port} of {host} cannot be used ({why}); give another with --port, 0 = any free one"
            ) from None

    async def _look(self) -> None:
        while True:
            found = await asyncio.to_thread(self._source.look) if self._clients else {}
            for topic, kind in found.items():
                if topic not in self._numbers and len(self._channels) < MOST_CHANNELS:
                    self._numbers[topic] = len(self._channels)
                    self._channels.append(self._encoding.channel(len(self._channels), topic, kind))
            for client in self._clients:
                client.ready.set()
            await asyncio.sleep(LOOK_PERIOD)

    async def _pass_on(self) -> None:
        async for wanted in self._while(lambda: self._wanted() - {ALARMS}, self._source.rest):
            read = await asyncio.to_thread(self._source.read, wanted)
            for number, (topic, message) in enumerate(read, 1):
                payload = self._encoding.message(message, self._start)
                self._publish(topic, self._time(message.stamp), payload)
                if number % TURN_MESSAGES == 0:
                    await asyncio.sleep(0)

    async def _watch_alarms(self) -> None:
        reported = 0
        async for _ in self._while(lambda: self._wanted() & {ALARMS}, self._alarms.rest):
            lines = await asyncio.to_thread(self._alarms.read)
            if (left_out := self.left_out) > reported:
                text = (
                    f"a client reads slowly: {left_out - reported} messages were left out, {left_out} in all"
                )
                lines.append(LogLine("warning", "bridge", text))
                reported = left_out
            now = self._time(time.monotonic_ns())
            for line in lines:
                self._publish(ALARMS, now, self._encoding.log(now, line.level, line.name, line.text))

    async def _while(
        self, wanted: Callable[[], set[str]], rest: Callable[[], None]
    ) -> AsyncIterator[set[str]]:
        """Yield what is wanted as long as there is any; else ``rest`` and wait."""
        while True:
            if topics := wanted():
                yield topics
            else:
                rest()
                self._changed.clear()
                await self._changed.wait()

    @property
    def left_out(self) -> int:
        """Messages that slow clients have not got, also of those that have gone."""
        return self.counts["left_out"] + sum(client.left_out for client in self._clients)

    def _wanted(self) -> set[str]:
        return {
            self._channels[number]["topic"] for client in self._clients for number in client.subscriptions
        }

    def _publish(self, topic: str, stamp: int, payload: bytes) -> None:
        number = self._numbers[topic]
        for client in self._clients:
            subscription = client.subscriptions.get(number)
            if subscription is not None:
                client.offer(frame(subscription, stamp, payload))

    def _time(self, stamp: int) -> int:
        """Return ``stamp`` [ns] since 1970, that of another machine's clock as now."""
        now = time.monotonic_ns()
        return (stamp if abs(stamp - now) < OWN_CLOCK * NS else now) + self._since_1970

    async def _attend(self, connection: ServerConnection) -> None:
        if len(self._clients) >= MOST_CLIENTS:
            await connection.close(1013, f"{MOST_CLIENTS} clients are connected already")
            return
        connection.transport.get_extra_info("socket").setsockopt(SOL_SOCKET, SO_SNDBUF, SOCKET_BYTES)
        client = Client(connection)
        self._clients.add(client)
        self.counts["clients"] += 1
        sender = asyncio.create_task(self._send(client))
        try:
            async for request in connection:
                await self._answer(client, request)
                self._changed.set()
        except ConnectionClosed:
            pass
        finally:
            self._clients.discard(client)
            self.counts["left_out"] += client.left_out
            sender.cancel()
            await asyncio.gather(sender, return_exceptions=True)

    async def _send(self, client: Client) -> None:
        info = {
            "name": "vegrip",
            "capabilities": ["parameters"],
            "metadata": {},
            "sessionId": str(self._start),
        }
        with contextlib.suppress(ConnectionClosed):
            await _say(client, {"op": "serverInfo", **info})
            while True:
                if new := self._channels[client.advertised :]:
                    client.advertised += len(new)
                    await _say(client, {"op": "advertise", "channels": new})
                if client.left_out > client.reported and time.monotonic() >= client.report_due:
                    client.reported, client.report_due = client.left_out, time.monotonic() + REPORT_PERIOD
                    text = f"{client.reported} messages were left out: this client reads slowly"
                    await _say(client, {"op": "status", "id": "slow", "level": WARNING, "message": text})
                if client.queue:
                    await client.connection.send(client.queue.popleft())
                    self.counts["sent"] += 1
                else:
                    client.ready.clear()
                    await client.ready.wait()

    async def _answer(self, client: Client, request: str | bytes) -> None:
        try:
            asked = json.loads(request) if isinstance(request, str) else {}
            match asked:
                case {"op": "subscribe", "subscriptions": list(pairs)}:
                    for pair in pairs:
                        self._subscribe(client, pair)
                case {"op": "unsubscribe", "subscriptionIds": list(ended)}:
                    kept = client.subscriptions.items()
                    client.subscriptions = {channel: one for channel, one in kept if one not in ended}
                case {"op": "getParameters", "parameterNames": list(names)}:
                    found = await asyncio.to_thread(_parameters, frozenset(map(str, names)))
                    message = {"op": "parameterValues", "parameters": found}
                    await _say(client, message | ({"id": asked["id"]} if "id" in asked else {}))
                case {"op": "setParameters"}:
                    raise ValueError("parameters are read here; set them with `vegrip param set`")
                case _:
                    raise ValueError("this server sends topics and parameters, and takes nothing else")
        except (ValueError, RecursionError) as error:
            self.counts["refused"] += 1
            text = str(error) or "nested too deeply"
            await _say(client, {"op": "status", "level": ERROR, "message": text})

    def _subscribe(self, client: Client, pair: Any) -> None:
        match pair:
            case {"id": int(subscription), "channelId": int(channel)} if 0 <= subscription < 2**32:
                if not 0 <= channel < len(self._channels):
                    raise ValueError(f"there is no channel {channel}")
                if channel in client.subscriptions:
                    raise ValueError(f"channel {channel} is subscribed to already")
                client.subscriptions[channel] = subscription
            case _:
                raise ValueError("a subscription needs the numbers id and channelId")


async def _say(client: Client, message: Mapping[str, Any]) -> None:
    await client.connection.send(json.dumps(message))


def _parameters(names: frozenset[str]) -> list[dict[str, Any]]:
    """Return the parameters of all nodes that run, as ``node.parameter``; ``names`` empty: all."""
    all_of_them = (
        (f"{entry.name}.{name}", value) for entry, said in node_parameters() for name, value in said.items()
    )
    return [{"name": n, "value": jsonable(value)} for n, value in all_of_them if not names or n in names]
