"""A node that finds its surroundings wrong says so: one sentence, an exit code, a lifecycle state.

Wrong bit rate, missing interface, two nodes with one id, a key that is wrong; an EDS that does not match is
in ``tests/canopen/test_trouble.py``.
"""

import json
import threading
import time

import pytest

from validation.faults.simulated_can import SimulatedCan
from vegrip.cli import main
from vegrip.clock import SimulatedClock, WallClock
from vegrip.errors import DeviceError
from vegrip.messages import FingertipState, ForceCommand, Lifecycle, NodeStatus, Reason
from vegrip.runtime.echo import EchoNode, EchoParameters
from vegrip.runtime.registry import Entry, registered
from vegrip.runtime.runner import Runner
from vegrip.runtime.sender_watch import HINTS, QUIET_NS, FaultHints
from vegrip.runtime.telemetry_socket import TelemetryReader
from vegrip.transport.codec import CanCodec
from vegrip.transport.curve import Curve, Keys
from vegrip.transport.key_files import make_keys, trust_key
from vegrip.transport.open import Hand, open_endpoint

FINGERS = ("thumb", "index")
pytestmark = pytest.mark.usefixtures("runtime")


def refused(capsys, code, *settings):
    """Run the echo node as a user would; return the one sentence it ends with."""
    arguments = [part for setting in settings for part in ("--set", f"transport.{setting}")]
    assert main(["node", "echo", *arguments]) == code
    said = capsys.readouterr().err
    assert "Traceback" not in said
    (sentence,) = (line for line in said.splitlines() if line.startswith("vegrip: "))
    return sentence


def finalized(capsys):
    """Return the reason that ``vegrip lifecycle`` gives for the end of the echo node."""
    assert main(["lifecycle", "status", "echo", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["state"] == "finalized"
    assert main(["lifecycle", "list", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["/echo"]["state"] == "finalized"
    return told["reason"]


def test_a_wrong_bit_rate_is_refused_with_both_rates_and_the_state_is_finalized(capsys):
    endpoint = open_endpoint({"channel": "rates", "bitrate": 1_000_000}, Hand(FINGERS))
    try:
        sentence = refused(capsys, 4, "channel=rates", "bitrate=500000")
    finally:
        endpoint.close()
    assert "runs at 1000000 and 5000000 bit/s, not at 500000 and 5000000; open it with the same" in sentence
    assert sentence.endswith(finalized(capsys))


def test_a_missing_interface_is_refused_with_the_remedy_and_the_state_is_finalized(capsys):
    sentence = refused(capsys, 4, "interface=socketcan", "channel=vegripnone")
    assert "ip link" in sentence or "modprobe" in sentence
    assert sentence.endswith(finalized(capsys))


def test_a_key_file_that_is_none_is_refused_with_its_name_and_the_state_is_finalized(capsys, tmp_path):
    keys = f'{{own="{tmp_path}/none", peers="{tmp_path}", publisher="{tmp_path}/none"}}'
    sentence = refused(capsys, 3, "kind=zmq", "publish=ipc:a", f"curve={keys}")
    assert f"{tmp_path}/none is no key file" in sentence
    assert sentence.endswith(finalized(capsys))


def test_those_who_follow_a_node_that_cannot_open_its_bus_get_its_last_status(capsys):
    with registered(Entry("/other", "echo")):
        reader = TelemetryReader([Entry("/echo", "echo")], ["/"])
    heard, over = [], threading.Event()

    def listen():
        while not over.is_set():
            heard.extend(message for *_, message in reader.read(0.05))

    thread = threading.Thread(target=listen)
    thread.start()
    try:
        refused(capsys, 4, "interface=socketcan", "channel=vegripnone")
        until = time.monotonic() + 60.0
        while not heard and time.monotonic() < until:
            thread.join(0.05)
    finally:
        over.set()
        thread.join()
        reader.close()
    assert [(type(m), m.state) for m in heard] == [(NodeStatus, Lifecycle.FINALIZED)]
    assert heard[0].rejected == {"bus_not_opened": 1}


def test_a_node_that_starts_again_takes_its_last_words_back(capsys):
    refused(capsys, 4, "interface=socketcan", "channel=vegripnone")
    finalized(capsys)
    with registered(Entry("/echo", "echo")):
        pass
    assert main(["lifecycle", "status", "echo"]) == 2


class Bus:
    """A simulated bus with one who commands already, and the loop of another who wants to."""

    def __init__(self):
        self.clock = SimulatedClock()
        bus = SimulatedCan(self.clock)
        self.other, self.hand = (bus.endpoint(CanCodec(FINGERS, fd=True)) for _ in range(2))
        own = bus.endpoint(CanCodec(FINGERS, fd=True))
        node = EchoNode("grasp_force", EchoParameters())  # a name that has a number on the bus
        self.runner = Runner(node, own, self.clock)

    def commanded(self, seq=0, finger="thumb"):
        now = self.clock.now()
        self.other.send(ForceCommand(now, finger, seq, 1.0, 0.0, Reason.HOLD, now + 10**8))

    def states(self):
        self.clock.advance(0.01)
        return [m.state for m in self.hand.receive(0.0) if isinstance(m, NodeStatus)]


def test_a_node_does_not_turn_active_where_another_commands_its_fingers_and_the_bus_is_told():
    bus = Bus()
    bus.runner.change("configure")
    bus.commanded()
    bus.clock.advance(0.002)  # the frame takes its time
    bus.runner.step()
    with pytest.raises(DeviceError, match=r"ForceCommand of thumb\): another node on this bus also sends"):
        bus.runner.change("activate")
    assert bus.runner.state is Lifecycle.INACTIVE
    bus.runner.give_up()
    assert bus.states()[-1] is Lifecycle.FINALIZED
    assert bus.runner.status.rejected["also_sent"] == 1


def test_a_silent_bus_lets_a_node_become_active_after_it_has_listened():
    bus = Bus()
    bus.runner.bring_up()
    assert bus.runner.state is Lifecycle.ACTIVE
    assert bus.clock.now() >= 100_000_000


def test_one_who_has_stopped_commanding_long_ago_is_no_hindrance():
    bus = Bus()
    bus.runner.change("configure")
    bus.commanded()
    bus.clock.advance(0.002)  # the frame takes its time
    bus.runner.step()
    bus.clock.advance(0.6)
    bus.runner.change("activate")
    assert bus.runner.state is Lifecycle.ACTIVE


def test_a_second_who_begins_to_command_is_counted_and_told_and_the_grip_goes_on(caplog):
    bus = Bus()
    bus.runner.bring_up()
    for seq in range(3):
        bus.commanded(seq)
        bus.clock.advance(0.5)
        bus.runner.step()
    assert bus.runner.state is Lifecycle.ACTIVE
    assert bus.runner.status.rejected["also_sent"] >= 2
    assert [record.message for record in caplog.records].count(HINTS["also_sent"]) == 1


def test_a_trouble_is_told_when_it_begins_and_again_only_after_quiet():
    remedies = FaultHints()
    told = [
        [name for name, _ in remedies.news({"bus_off": count}, now)]
        for count, now in ((0, 0), (1, 10), (2, 20), (2, 30), (3, 25 + QUIET_NS), (4, 30 + QUIET_NS))
    ]
    assert told == [[], ["bus_off"], [], [], ["bus_off"], []]


@pytest.fixture
def network(tmp_path):
    """Make keys of a hand, a node and a stranger; give an opener of their endpoints."""
    for name in ("hand", "node", "stranger"):
        make_keys(tmp_path, name)
    trust_key(tmp_path / "node.key", tmp_path / "peers")
    opened = []

    def end(own, publisher, **ends):
        table = {"own": str(tmp_path / f"{own}.key_secret"), "peers": str(tmp_path / "peers")}
        table["publisher"] = str(tmp_path / f"{publisher}.key")
        Keys(Curve(**table))
        opened.append(open_endpoint({"kind": "zmq", "curve": table, **ends}, Hand(FINGERS)))
        return opened[-1]

    yield end
    for endpoint in opened:
        endpoint.close()


def counted(endpoint, name):
    until = time.monotonic() + 20.0
    while not endpoint.rejected.get(name) and time.monotonic() < until:
        endpoint.receive(0.02)
    return endpoint.rejected.get(name, 0)


@pytest.mark.parametrize(
    ("own", "publisher", "ours", "theirs"),
    [("stranger", "hand", "key_refused", "key_unknown"), ("node", "stranger", "key_wrong", "key_stale")],
)
def test_a_key_that_is_wrong_is_counted_by_both_sides_and_the_node_stays_inactive(
    network, own, publisher, ours, theirs
):
    hand = network("hand", "node", publish="ipc:hand")
    node = network(own, publisher, subscribe=["ipc:hand"])
    assert counted(node, ours)
    assert counted(hand, theirs)
    assert node.in_trouble
    assert not hand.in_trouble, "strangers at the door are no reason to stop"
    runner = Runner(EchoNode("echo", EchoParameters()), node, WallClock())
    runner.bring_up()
    assert runner.state is Lifecycle.INACTIVE
    assert runner.status.state is Lifecycle.INACTIVE
    assert runner.status.rejected[ours] >= 1


def test_with_the_right_keys_a_node_turns_active(network):
    hand = network("hand", "node", publish="ipc:hand")
    node = network("node", "hand", subscribe=["ipc:hand"])
    for seq in range(2000):
        hand.send(FingertipState(time.monotonic_ns(), "thumb", seq, normal_force=1.0))
        if node.receive(0.01):
            break
    runner = Runner(EchoNode("echo", EchoParameters()), node, WallClock())
    runner.bring_up()
    assert runner.state is Lifecycle.ACTIVE
    assert not hand.rejected
