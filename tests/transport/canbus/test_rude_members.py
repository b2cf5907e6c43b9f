"""Members of the virtual bus that misbehave: the bus lives on for the others, and ends when all have left."""

import json
import select
import socket
import time
from itertools import pairwise
from pathlib import Path

import can
import pytest
from hypothesis import given
from hypothesis import strategies as st

from validation.faults.simulated_bus import SimulatedBus
from vegrip.errors import ConfigError
from vegrip.host.folders import runtime_folder
from vegrip.transport.canbus import hub
from vegrip.transport.canbus.bus_events import ErrorState, NodeFaults
from vegrip.transport.canbus.frame_time import BitTiming
from vegrip.transport.canbus.hub_wire import (
    HUB_VERSION,
    MAX_PACKET_BYTES,
    MAX_REASON_CHARS,
    make_greeting,
    read_greeting,
)

SECOND = 10**9
PATIENCE = 30.0  # [s] on a busy machine


@pytest.fixture
def bus(runtime):
    opened = []

    def open_bus(**options):
        opened.append(can.Bus(interface="vegrip", channel="test", **options))
        return opened[-1]

    yield open_bus
    for each in opened:
        each.shutdown()


def hub_process():
    lock = runtime_folder("can") / "test.lock"
    while not lock.read_text().endswith("\n"):
        time.sleep(0.01)
    return Path(f"/proc/{int(lock.read_text())}")


def ends(process):
    end = time.monotonic() + PATIENCE
    while process.exists() and time.monotonic() < end:
        time.sleep(0.05)
    return not process.exists()


def newcomer():
    connection = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    connection.settimeout(PATIENCE)
    connection.connect(str(runtime_folder("can") / "test.bus"))
    return connection


def frames_go_through(one, other):
    one.send(can.Message(arbitration_id=0x123, data=b"x", is_extended_id=False))
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        got = other.recv(0.1)
        if got is not None and got.arbitration_id == 0x123 and not got.is_error_frame:
            return True
    return False


@pytest.mark.parametrize(("identifier", "corruption"), [(0, 1.0), (0x7FF, 0.0)])
def test_the_hub_ends_after_a_lone_member_that_babbled(bus, identifier, corruption):
    alone = bus(faults={"babble": identifier, "corruption": corruption})
    process = hub_process()
    alone.shutdown()
    assert ends(process)


def test_others_join_and_talk_while_one_babbles_and_when_it_has_left(bus):
    babbler = bus(faults={"babble": 0x7FF})
    one, other = bus(), bus()
    assert frames_go_through(one, other)
    babbler.shutdown()
    assert frames_go_through(other, one)


@pytest.mark.parametrize("uptime", [0, SECOND, 10**18])
@pytest.mark.parametrize("corruption", [0.0, 1.0])
def test_a_lone_babbler_costs_a_handful_of_events_whatever_the_clock_says(uptime, corruption):
    model = SimulatedBus(BitTiming())
    model.attach(1, faults=NodeFaults(babble=0x100, corruption=corruption), time=uptime)
    events = model.advance(uptime + SECOND // 10)
    assert len(events) < 2000
    model.detach(1)
    for later in range(1, 5):
        model.conclude(uptime + later * SECOND)
        model.advance(uptime + later * SECOND)
    assert model.next_event() is None
    assert model.queued == 0


def test_a_lone_babbler_whose_time_is_made_up_for_at_once_is_skipped_over():
    model = SimulatedBus(BitTiming())
    model.attach(1, faults=NodeFaults(babble=0x100))
    assert len(model.advance(10**16)) < 50
    assert model.state(1) is ErrorState.PASSIVE


def test_one_who_only_listens_does_not_babble_either():
    model = SimulatedBus(BitTiming())
    model.attach(1)
    model.attach(2, listen_only=True, faults=NodeFaults(babble=0x100))
    assert model.advance(SECOND) == []


def test_a_babbler_begins_when_it_joins_and_not_when_the_bus_fell_silent():
    model = SimulatedBus(BitTiming())
    model.attach(1)
    model.attach(2, faults=NodeFaults(babble=0x100), time=1000 * SECOND)
    sent = model.advance(1000 * SECOND + SECOND // 100)
    assert sent[0].start == 1000 * SECOND
    assert all(before.end <= after.start for before, after in pairwise(sent))


BAD_FAULTS = [
    *(
        {name: value}
        for name in ("misreading", "loss", "corruption", "flips", "delay", "jitter")
        for value in ("x", None, [1], {}, -0.1, 1e9, float("nan"), True)
    ),
    *({"babble": value} for value in ("x", 1.5, None, [1], 0x800, -2)),
    *({"seed": value} for value in ([1], -1, "x")),
    {"unknown": 1},
]
BAD_GREETINGS = [
    *({"faults": faults} for faults in (*BAD_FAULTS, "x", [1], None)),
    *({"timing": {"bitrate": value}} for value in (0, -5, "fast", 1.5, 1e308)),
    *({"timing": {"data_bitrate": value}} for value in (None, 0)),
    {"timing": 5},
    {"must_match_rates": "yes"},
    {"wants_own_frames": 1},
    {"listen_only": []},
    *({"version": value} for value in (HUB_VERSION + 1, "x" * 400, None)),
    {"\u20ac" * 50: 1},
]


def refuses(error, call, *arguments, **options):
    """Return what is said by a call that must refuse its arguments, which are shown where it does not."""
    try:
        call(*arguments, **options)
    except error as told:
        return str(told)
    pytest.fail(f"{arguments} {options} are taken")


def test_the_hub_refuses_what_the_bus_refuses():
    for bad in BAD_GREETINGS:
        greeting = json.dumps({"version": HUB_VERSION, **bad}).encode()
        assert len(refuses(ConfigError, read_greeting, greeting)) <= MAX_REASON_CHARS
        if bad.get("version", HUB_VERSION) == HUB_VERSION and None not in bad.values():
            assert refuses(ConfigError, make_greeting, bad)


def test_bad_faults_are_refused_where_they_are_given(runtime):
    for faults in BAD_FAULTS:
        refuses(can.CanInitializationError, can.Bus, interface="vegrip", channel="test", faults=faults)


PACKETS = [b"[" * 500, b"\xff" * 500, b"{}", b"[]", b"1", b"null", b'"x"', b"nonsense"]


def test_after_any_greeting_the_bus_serves_its_members_on(bus):
    one, other = bus(), bus()
    greetings = [json.dumps({"version": HUB_VERSION, **bad}).encode() for bad in BAD_GREETINGS]
    for packet in greetings + PACKETS:
        with newcomer() as stranger:
            stranger.send(packet)
            answer = stranger.recv(MAX_PACKET_BYTES)
            assert "refused" in json.loads(answer)
    assert frames_go_through(one, other)


@given(packet=st.binary(max_size=MAX_PACKET_BYTES))
def test_any_bytes_are_a_greeting_or_refused(packet):
    try:
        read_greeting(packet)
    except ConfigError as error:
        assert len(json.dumps({"refused": str(error)})) <= MAX_PACKET_BYTES  # noqa: PT017


def test_a_good_greeting_is_understood_as_it_was_said():
    said = {
        "timing": {"bitrate": 250_000},
        "faults": {"babble": 5, "seed": 7, "loss": 1},
        "wants_own_frames": True,
    }
    heard = read_greeting(make_greeting(said))
    assert (heard.timing.bitrate, heard.wants_own_frames, heard.must_match_rates) == (250_000, True, False)
    assert heard.faults == NodeFaults(babble=5, seed=7, loss=1.0)


def test_more_members_than_there_is_room_for_are_refused_with_the_reason(bus):
    one, other = bus(), bus()
    crowd = []
    for _ in range(hub.MOST_MEMBERS - 2):
        crowd.append(newcomer())
        crowd[-1].send(make_greeting({}))
        assert "node" in json.loads(crowd[-1].recv(MAX_PACKET_BYTES))
    with pytest.raises(can.CanInitializationError, match="no room"):
        bus()
    for each in crowd:
        each.close()
    assert frames_go_through(one, other)
    bus()


def test_a_member_that_stays_keeps_its_number_for_itself_while_all_numbers_pass(tmp_path, monkeypatch):
    monkeypatch.setattr(hub, "NODES", 3)
    path, numbers, here = str(tmp_path / "bus"), [], []
    with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as listener:
        listener.bind(path)
        listener.listen()
        door = hub.Hub(listener)
        for _ in range(6):
            here.append(socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET))
            here[-1].connect(path)
            here[-1].send(make_greeting({}))
            while not select.select(here[-1:], [], [], 0)[0]:
                door._step()
            numbers.append(json.loads(here[-1].recv(MAX_PACKET_BYTES))["node"])
            if len(here) > 1:  # only the first one stays
                here.pop().close()
            while len(door._members) > 1:
                door._step()
        here.pop().close()
        while door._members:
            door._step()
    assert numbers[0] not in numbers[1:]
    assert set(numbers[1:]) == {0, 2, 3}


def test_who_says_nothing_is_let_go(bus):
    one, other = bus(), bus()
    silent = [newcomer() for _ in range(20)]
    assert frames_go_through(one, other)
    for each in silent:
        assert each.recv(MAX_PACKET_BYTES) == b"", "the end of the connection"
        each.close()
    assert frames_go_through(other, one)
