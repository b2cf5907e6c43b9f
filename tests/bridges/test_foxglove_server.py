"""Laws of the server for Foxglove: every message once, and a client that misbehaves costs only itself."""

import asyncio
import json
import socket
import threading

import pytest

from tests.bridges.foxglove_peer import Given, peer
from vegrip.messages import Estimate, FingertipState, SlipMargin

THUMB = "/hand/thumb"


def states(count, **values):
    return [("thumb", FingertipState(n, "thumb", n, normal_force=float(n), **values)) for n in range(count)]


def test_a_thousand_messages_arrive_once_each_and_in_order(serving) -> None:
    source = Given(thumb=FingertipState)

    async def conversation(port) -> None:
        async with peer(port) as client:
            await client.subscribe(THUMB)
            for state in states(1000):
                source.put(state)
            heard = [await client.data() for _ in range(1000)]
            assert [json.loads(payload)["normal_force"] for _, _, payload in heard] == list(range(1000))
            assert {subscription for subscription, _, _ in heard} == {100 + client.channels[THUMB]["id"]}

    assert serving(source, conversation).left_out == 0


def test_a_channel_states_the_unit_of_every_number(serving) -> None:
    async def conversation(port) -> None:
        async with peer(port) as client:
            await client.waits_for("serverInfo")
            while THUMB not in client.channels:
                await client.hear()
            fields = json.loads(client.channels[THUMB]["schema"])["properties"]
            assert fields["margin"]["description"] == "[1]"
            assert fields["force_reserve"]["description"] == "[N]"
            assert fields["time_to_slip"]["description"] == "[s]"
            assert all("description" in one for one in fields.values() if one["type"] == "number")

    serving(Given(thumb=SlipMargin), conversation)


def test_what_is_not_known_is_left_out_and_never_is_infinite(serving) -> None:
    source = Given(thumb=SlipMargin)
    margin = SlipMargin(1, "thumb", 7, Estimate(0.25, 0.5, valid=True, age=0.0), time_to_slip=float("inf"))

    async def conversation(port) -> None:
        async with peer(port) as client:
            await client.subscribe(THUMB)
            source.put(("thumb", margin))
            row = json.loads((await client.data())[2])
            assert (row["margin"], row["margin_std"], row["margin_valid"]) == (0.25, 0.5, 1)
            assert row["time_to_slip"] == float("inf")
            assert "lower_bound" not in row

    serving(source, conversation)


@pytest.mark.long
def test_a_client_that_reads_nothing_costs_bounded_memory_and_what_it_loses_is_counted(serving) -> None:
    source, count = Given(thumb=FingertipState), 20_000
    told = []

    async def conversation(port) -> None:
        with socket.socket() as narrow:
            narrow.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            narrow.connect(("127.0.0.1", port))
            narrow.setblocking(False)
            await compare(port, narrow.dup())

    async def compare(port, narrow) -> None:
        async with peer(port, sock=narrow, max_queue=1) as slow, peer(port) as quick:
            await slow.subscribe(THUMB)
            await quick.subscribe(THUMB)
            for first in range(0, count, 500):
                source.put(*states(count, displacement=0.123456789)[first : first + 500])
                for _ in range(500):
                    await quick.data()
            source.put(("thumb", FingertipState(0, "thumb", 0, normal_force=-1.0)))
            heard = [json.loads((await slow.data())[2])["normal_force"]]
            while heard[-1] != -1.0:
                heard.append(json.loads((await slow.data())[2])["normal_force"])
            assert heard[:-1] == sorted(heard[:-1])
            told.append(count + 1 - len(heard))
            said = [one["message"] for one in slow.told if one["op"] == "status"]
            assert said
            assert said[-1].endswith("messages were left out: this client reads slowly")
            assert not [one for one in quick.told if one["op"] == "status"]

    server = serving(source, conversation)
    assert server.left_out == told[0] > 0


@pytest.mark.parametrize(
    ("request_", "complaint"),
    [
        ("no JSON", "Expecting value"),
        ("[" * 60_000, ""),
        ("[]", "takes nothing else"),
        (b"\x01\x00", "takes nothing else"),
        ('{"op": "advertise", "channels": []}', "takes nothing else"),
        ('{"op": "subscribe", "subscriptions": [{"id": 1, "channelId": 999}]}', "there is no channel 999"),
        ('{"op": "subscribe", "subscriptions": [{"id": -1, "channelId": 0}]}', "needs the numbers"),
        ('{"op": "subscribe", "subscriptions": [7]}', "needs the numbers"),
        ('{"op": "setParameters", "parameters": []}', "parameters are read here"),
    ],
)
def test_a_request_that_is_wrong_is_answered_in_a_sentence_and_counted(serving, request_, complaint) -> None:
    async def conversation(port) -> None:
        async with peer(port) as client:
            await client.socket.send(request_)
            told = await client.waits_for("status")
            assert told["level"] == 2
            assert complaint in told["message"]
            await client.subscribe(THUMB)

    assert serving(Given(thumb=FingertipState), conversation).counts["refused"] == 1


def test_a_web_site_in_the_same_browser_is_refused_and_the_application_is_not(serving) -> None:
    from websockets.exceptions import InvalidStatus

    async def conversation(port) -> None:
        for origin in ("https://example.org", "http://127.0.0.1.example.org", "https://app.foxglove.dev.org"):
            with pytest.raises(InvalidStatus, match="403"):
                async with peer(port, origin=origin):
                    pass
        for origin in ("https://app.foxglove.dev", "http://localhost:8080", "file://", None):
            async with peer(port, origin=origin) as client:
                await client.waits_for("serverInfo")

    serving(Given(), conversation)


def test_nodes_are_left_alone_when_no_client_wants_anything(serving) -> None:
    source = Given(thumb=FingertipState)

    async def conversation(port) -> None:
        async with peer(port) as client:
            await client.subscribe(THUMB)
            source.put(*states(1))
            await client.data()
            before = source.rests
            await client.say(op="unsubscribe", subscriptionIds=[100 + client.channels[THUMB]["id"]])
            async with asyncio.timeout(20):
                while source.rests == before:
                    await asyncio.sleep(0)

    serving(source, conversation)


def test_a_port_in_use_is_one_sentence(serving) -> None:
    from vegrip.bridges.foxglove_channels import Json
    from vegrip.bridges.foxglove_server import FoxgloveServer
    from vegrip.errors import DeviceError

    async def conversation(port) -> None:
        with pytest.raises(DeviceError, match=rf"port {port} of 127.0.0.1 cannot be used"):
            await FoxgloveServer(Given(), Json()).run("127.0.0.1", port, lambda _: None)

    serving(Given(), conversation)


class Subscribed:
    def __init__(self) -> None:
        self.event = threading.Event()

    def on_subscribe(self, *_) -> None:
        self.event.set()

    def on_unsubscribe(self, *_) -> None:
        pass


def test_the_wire_is_that_of_a_server_of_the_maker(serving) -> None:
    foxglove = pytest.importorskip("foxglove")
    source = Given(thumb=FingertipState)
    context = foxglove.Context()

    async def dialogue(port):
        async with peer(port) as client:
            info = await client.waits_for("serverInfo")
            await client.subscribe(THUMB)
            return info, client

    async def conversation(port) -> None:
        info, client = await dialogue(port)
        ours = client.channels[THUMB]
        schema = foxglove.Schema(name=ours["schemaName"], encoding="jsonschema", data=ours["schema"].encode())
        channel = foxglove.Channel(THUMB, schema=schema, message_encoding="json", context=context)
        subscribed = Subscribed()
        asks = [foxglove.websocket.Capability.Parameters]
        server = foxglove.start_server(port=0, context=context, capabilities=asks, server_listener=subscribed)
        try:
            async with peer(server.port) as other, peer(port) as mine:
                theirs = await other.waits_for("serverInfo")
                assert info.keys() == theirs.keys()
                assert set(info["capabilities"]) <= set(theirs["capabilities"])
                await mine.subscribe(THUMB)
                await other.ask_for(THUMB)
                assert await asyncio.to_thread(subscribed.event.wait, 20.0)
                assert ours | {"id": 0} == other.channels[THUMB] | {"id": 0}
                source.put(*states(1))
                _, stamp, payload = await mine.data()
                channel.log(payload, log_time=stamp)
                assert (await other.data())[1:] == (stamp, payload)
        finally:
            server.stop()
            channel.close()

    serving(source, conversation)
