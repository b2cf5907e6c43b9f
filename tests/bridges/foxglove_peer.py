"""A source of messages of ours, and a client that knows Foxglove's protocol and nothing of vegrip."""

import asyncio
import json
import queue
import struct
from contextlib import asynccontextmanager

PATIENCE = 20.0  # [s] on a busy machine


class Given:
    """A source of messages that are put in."""

    def __init__(self, **kinds) -> None:
        self.kinds = kinds
        self.batches: queue.Queue = queue.Queue()
        self.rests = 0

    def look(self):
        return {f"/hand/{name}": kind for name, kind in self.kinds.items()}

    def put(self, *pairs) -> None:
        self.batches.put([(f"/hand/{name}", message) for name, message in pairs])

    def read(self, topics):
        try:
            return [(topic, message) for topic, message in self.batches.get(timeout=0.02) if topic in topics]
        except queue.Empty:
            return []

    def rest(self) -> None:
        self.rests += 1


class Peer:
    """A client of Foxglove's protocol."""

    def __init__(self, socket) -> None:
        self.socket = socket
        self.channels: dict[str, dict] = {}
        self.told: list[dict] = []

    async def say(self, **told) -> None:
        await self.socket.send(json.dumps(told))

    async def hear(self):
        """Return the next message: a dict of text, or subscription, time [ns] and payload."""
        raw = await asyncio.wait_for(self.socket.recv(), PATIENCE)
        if isinstance(raw, bytes):
            opcode, subscription, stamp = struct.unpack("<BIQ", raw[:13])
            assert opcode == 1
            return subscription, stamp, raw[13:]
        told = json.loads(raw)
        self.told.append(told)
        for channel in told.get("channels", ()) if told["op"] == "advertise" else ():
            self.channels[channel["topic"]] = channel
        return told

    async def waits_for(self, op: str) -> dict:
        while True:
            told = await self.hear()
            if isinstance(told, dict) and told["op"] == op:
                return told

    async def data(self):
        while True:
            told = await self.hear()
            if isinstance(told, tuple):
                return told

    async def subscribe(self, *topics: str) -> None:
        """Subscribe to each topic under 100 + the number of its channel, and wait until that is so."""
        await self.ask_for(*topics)
        await self.say(op="getParameters", parameterNames=["none"], id="now")
        await self.waits_for("parameterValues")

    async def ask_for(self, *topics: str) -> None:
        while not set(topics) <= self.channels.keys():
            await self.hear()
        numbers = [self.channels[topic]["id"] for topic in topics]
        await self.say(op="subscribe", subscriptions=[{"id": 100 + n, "channelId": n} for n in numbers])


@asynccontextmanager
async def peer(port: int, **options):
    from websockets.asyncio.client import connect

    options = {"subprotocols": ["foxglove.sdk.v1"], **options}
    async with connect(f"ws://127.0.0.1:{port}", **options) as socket:
        yield Peer(socket)
