"""The virtual device of each map in the box: what it sends is read, and it holds an object, under faults.

In simulated time: the hand feels, the device packs, the endpoint reads, the node answers, the device obeys.
"""

import math
import os
import re
import time
from collections import deque
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from tests.transport.maps.hands import PLAIN_DBC, PLAIN_MAP, seeded, written
from vegrip.clock import NS
from vegrip.demo.product import open_product
from vegrip.errors import ConfigError, DeviceError, InputError
from vegrip.messages import DeviceReport, FingertipState, ForceCommand, Reason
from vegrip.transport.byte_link import Link
from vegrip.transport.canbus.hub_wire import PLAIN_FLAGS, pack_request
from vegrip.transport.codec import Frame
from vegrip.transport.hands import link_endpoint
from vegrip.transport.hands.link_endpoint import MappedLinkEndpoint
from vegrip.transport.hands.virtual_device import VirtualDevice
from vegrip.transport.mapped.codec import MappedCodec
from vegrip.transport.mapped.plan import open_plan
from vegrip.transport.maps import dialogue
from vegrip.transport.maps.products import about, names
from vegrip.transport.open import Hand, open_endpoint
from vegrip.trials import candidates
from vegrip.virtual import VirtualHand

PERIOD = 0.002  # [s]
FELT = {
    "normal_force": 2.0, "tangential_force_x": 0.5, "tangential_force_y": -0.25, "torque_z": 0.012,
    "temperature": 31.0, "displacement": 1.2e-3,
}  # fmt: skip


class Cable(Link):
    """Between an endpoint and a device, both in the time of the test."""

    def __init__(self, wire, *, is_datagram):
        self.wire, self.is_datagram, self.is_connection = wire, is_datagram, False
        self.readable, self._other = os.pipe()
        os.write(self._other, b"1")  # there may always be something

    def fileno(self):
        return self.readable

    def read(self):
        if self.wire.is_cut:
            raise OSError
        return self.wire.arriving.popleft() if self.wire.arriving else b""

    def _send(self, data):
        if self.wire.is_cut:
            raise OSError
        self.wire.device.take_in(Frame(-1, data, False, self.wire.now), self.wire.now)
        return len(data)

    def close(self):
        os.close(self.readable)
        os.close(self._other)


class Wire:
    """A node's end and a device's end of one product, with what may go wrong between them."""

    def __init__(self, product, monkeypatch):
        self.now, self.is_cut, self.harm = NS, False, lambda data: data
        self.arriving, self.reports = deque(), []
        plan = product.plan
        self.device = VirtualDevice(plan, product.latency)
        self.codec = MappedCodec(plan)
        self.endpoint = None
        monkeypatch.setattr(dialogue, "SILENT_AFTER", 3 * NS // 10)
        if plan.database.packets:
            clock = SimpleNamespace(monotonic_ns=lambda: self.now, sleep=lambda _: None)
            monkeypatch.setattr(link_endpoint, "time", clock)
            monkeypatch.setattr(link_endpoint, "REOPEN_PERIOD", NS // 10)
            self.endpoint = MappedLinkEndpoint([(self.opened(), lambda _: self.opened())], self.codec)

    def opened(self):
        if self.is_cut:
            raise OSError
        return Cable(self, is_datagram=self.codec.plan.hand.transport["kind"] == "udp")

    @property
    def faults(self):
        return dict(self.codec.rejected if self.endpoint is None else self.endpoint.rejected)

    def exchange(self):
        """Return the states that are read now."""
        if self.endpoint is not None:
            self.arriving += [self.harm(frame.data) for frame in self.device.due(self.now)]
            if self.is_cut:
                self.arriving.clear()
            heard = self.endpoint.receive(0.0)
            self.reports += [one for one in heard if isinstance(one, DeviceReport)]
            return [one for one in heard if isinstance(one, FingertipState)]
        for frame in () if self.is_cut else self.codec.due(self.now):
            self.device.take_in(frame, self.now)
        sent = [frame._replace(data=self.harm(frame.data)) for frame in self.device.due(self.now)]
        return [
            state
            for frame in (() if self.is_cut else sent)
            for state in self.codec.decode_all(frame._replace(stamp=self.now))
        ]

    def command(self, command):
        if self.endpoint is not None:
            self.endpoint.send(command)
        elif not self.is_cut:
            for frame in self.codec.encode(command):
                self.device.take_in(frame, self.now)


ROOT = Path(__file__).parents[3]


def of_the_tutorial(folder):
    """Write the file of the tutorial for a sensor that is in no box; return its path."""
    text = (ROOT / "docs" / "tutorials" / "your-sensor.md").read_text()
    path = folder / "made_up.toml"
    path.write_text(re.findall(r"```toml\n(.*?)```", text, re.DOTALL)[0])
    return str(path)


FEELING = [name for name in names() if about(name)["channels"]]


@pytest.fixture(params=[*FEELING, "of the tutorial", str(ROOT / "examples" / "hands" / "asked_gripper.toml")])
def product(request, tmp_path):
    name = of_the_tutorial(tmp_path) if request.param == "of the tutorial" else request.param
    return open_product(name, tmp_path)


def test_what_a_device_sends_is_what_it_feels_to_its_resolution(product, monkeypatch):
    wire, states = Wire(product, monkeypatch), {}
    for number in range(200):
        wire.now += NS // 500
        for finger in product.fingers:
            wire.device.sense(FingertipState(wire.now, finger, number, **FELT))
        states |= {state.finger: state for state in wire.exchange()}
        if number == 150:
            for finger in product.fingers:
                wire.command(ForceCommand(wire.now, finger, 0, 3.21, 0.0, Reason.HOLD, wire.now + NS))
    assert set(states) == set(product.fingers)
    for finger in product.plan.fingers:
        for name in finger.measured:
            step = {"torque_z": 1e-3, "temperature": 1.0}.get(name, 0.1)
            assert getattr(states[finger.name], name) == pytest.approx(FELT[name], abs=0.51 * step)
    assert dict(wire.device.taken()) == pytest.approx(dict.fromkeys(product.fingers, 3.21), abs=0.01)
    assert not wire.device.counts
    assert not wire.faults.keys() - {"resync"}  # what was an answer to the opening is no packet


@pytest.mark.parametrize("product", ["contactile-papillarray"], indirect=True)
def test_a_device_that_watches_slip_states_the_friction_of_the_last_slide_by_the_law_of_coulomb(
    product, monkeypatch
):
    wire = Wire(product, monkeypatch)
    for number in range(300):
        wire.now += NS // 500
        slides = 100 <= number < 110
        load = {"tangential_force_x": 1.2, "tangential_force_y": -0.9} if slides else {}
        for finger in product.fingers:
            felt = FELT | load | {"slip": float(slides)}
            wire.device.sense(FingertipState(wire.now, finger, number, **felt))
        wire.exchange()
    first, last = wire.reports[0], wire.reports[-1]
    assert math.isnan(first.friction)
    assert math.isnan(first.grip_force)
    assert (last.slip_state, last.friction) == (1.0, pytest.approx(1.5 / 2.0))
    assert last.grip_force == pytest.approx(math.hypot(0.5, 0.25) / 0.75, rel=1e-6)


def hold(product, wire, seconds, disturb):
    """Hold an object for so long; return the hand, what was commanded, and when which finger was heard."""
    scenario = product.scenario(seed=1, duration=seconds)
    node = candidates.make_node(product.parameters(scenario), product.fingers)
    node.configure()
    node.activate()
    hand = VirtualHand(scenario.settings, scenario.seed)
    hand.epoch = wire.now
    asked, heard = dict.fromkeys(hand.fingers, math.nan), []
    while hand.time < seconds:
        wire.now = hand.epoch + round((hand.time + PERIOD) * NS)
        disturb(hand.time)
        for sample in hand.advance(PERIOD, np.array(list(asked.values()))):
            for state in sample.states(hand.fingers):
                wire.device.sense(state)
        states = wire.exchange()
        heard += [(hand.time, state.finger) for state in states]
        answers = [answer for state in states for answer in node.on_message(state, wire.now)]
        for answer in (*answers, *node.on_tick(wire.now)):
            if isinstance(answer, ForceCommand):
                wire.command(answer)
        asked |= dict(wire.device.taken())
    assert not hand.dropped
    assert hand.slips == 0
    assert all(force > 0.3 for finger, force in asked.items() if finger in product.fingers)
    return heard


def unharmed(data):
    return data


def test_an_object_is_held_through_a_cut_cable_a_wrong_length_and_a_reset(product, monkeypatch):
    wire = Wire(product, monkeypatch)

    def disturb(t):
        wire.is_cut = 1.5 < t < 1.8
        wire.harm = (lambda data: data[:-1]) if 2.3 < t < 2.6 else unharmed
        if 3.2 < t < 3.2 + PERIOD:
            wire.device.reset()

    heard = hold(product, wire, 5.0, disturb)
    assert wire.faults
    for begin, end in ((1.0, 1.5), (2.1, 2.3), (2.9, 3.2), (4.4, 5.0)):  # before, between and after
        came = {finger for t, finger in heard if begin < t < end}
        assert came == set(product.fingers), (begin, wire.faults)


@pytest.mark.long
@pytest.mark.parametrize("product", ["onrobot-hex", "tesollo-dg5f"], indirect=True)
def test_the_grip_is_unharmed_by_twenty_faults_of_the_stream_a_minute(product, monkeypatch):
    wire, drawn = Wire(product, monkeypatch), seeded(7)
    seconds = float(os.environ.get("VEGRIP_STREAM_FAULTS_S", "30"))
    kinds = {
        "cut": unharmed,
        "shorter": lambda data: data[:-1],
        "longer": lambda data: data + b"\0",
        "merged": lambda data: data[: len(data) // 2] + data,
        "noise": lambda data: drawn.randbytes(len(data)),
        "a bit": lambda data: data[:-1] + bytes([data[-1] ^ 1 << drawn.randrange(8)]),
        "reset": unharmed,
    }
    faults = sorted(
        (drawn.uniform(1.5, seconds - 1.0), drawn.uniform(0.02, 0.3), drawn.choice(list(kinds)))
        for _ in range(round(seconds / 3.0))
    )

    def disturb(t):
        acting = [kind for begin, length, kind in faults if begin < t < begin + length]
        wire.is_cut, wire.harm = "cut" in acting, kinds[acting[0]] if acting else unharmed
        if "reset" in acting:
            wire.device.reset()

    heard = hold(product, wire, seconds, disturb)
    assert wire.faults
    assert {finger for t, finger in heard if t > seconds - 1.0} == set(product.fingers)


@pytest.mark.parametrize("name", ["onrobot-hex", "tesollo-dg5f", "bota-sensone", "dexhand021"])
def test_a_device_is_found_on_its_carrier(name, tmp_path):
    product = open_product(name, tmp_path)
    at_device, at_node = product.transports(tmp_path)
    states, forces, end = {}, {}, time.monotonic() + 20.0
    with (
        open_endpoint(at_device, Hand(product.fingers)) as device,
        open_endpoint(at_node, Hand(product.fingers)) as node,
    ):
        while time.monotonic() < end and not (states.keys() == forces.keys() == set(product.fingers)):
            for number, finger in enumerate(product.fingers):
                device.send(FingertipState(0, finger, number, **FELT))
                now = time.monotonic_ns()
                node.send(ForceCommand(now, finger, number, 3.21, 0.0, Reason.HOLD, now + NS))
            forces |= {command.finger: command.normal_force for command in device.receive(0.001)}
            found = node.receive(0.001)
            states |= {one.finger: one.normal_force for one in found if isinstance(one, FingertipState)}
    assert states == pytest.approx(dict.fromkeys(product.fingers, 2.0), abs=0.06)
    assert forces == pytest.approx(dict.fromkeys(product.fingers, 3.21), abs=0.01)


@pytest.mark.parametrize(("name", "is_blind"), [("bota-sensone", False), ("dexhand021", True)])
def test_a_demonstration_without_torque_says_beforehand_that_a_twist_is_not_answered(
    name, is_blind, tmp_path
):
    assert ("no torque is measured" in open_product(name, tmp_path).describe()) == is_blind


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"map": "tcp", "address": "192.168.1.1:502"}, "a virtual device is at 127.0.0.1:PORT"),
        ({"map": "tcp", "address": ""}, "a virtual device is at 127.0.0.1:PORT"),
        ({"map": "serial", "address": "/proc/tty"}, "name a file that is none"),
        ({"map": "topics"}, "have a virtual device"),
    ],
)
def test_a_device_that_cannot_be_is_told_in_one_sentence(settings, said, tmp_path):
    topics = 'format = "json"\n[fingers.tip]\nnormal_force = { signal = "a:b" }\n'
    (tmp_path / "topics.toml").write_text(topics)
    for kind, name in (("tcp", "tesollo-dg5f"), ("serial", "bota-sensone")):
        open_product(name, tmp_path).path.rename(tmp_path / f"{kind}.toml")
    table = {"kind": "device", **settings, "map": str(tmp_path / f"{settings['map']}.toml")}
    fingers = ("thumb",) if settings["map"] == "tcp" else ("tip",)
    with pytest.raises((ConfigError, DeviceError), match=said) as caught:
        open_endpoint(table, Hand(fingers))
    assert "\n" not in str(caught.value)


def test_a_database_without_a_command_holds_nothing(tmp_path):
    path = tmp_path / "mute.toml"
    path.write_text('database = "a.dbc"\n[fingers.tip]\nnormal_force = { signal = "A.b" }\n')
    with pytest.raises(ConfigError, match="holds nothing"):
        open_product(str(path), tmp_path / "out")
    with pytest.raises(InputError, match="there is no map of 'tesolo'"):
        open_product("tesolo", tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_hand_of_a_database_is_its_own_device_with_position_commands(tmp_path):
    text = PLAIN_MAP.replace('signal = "Set1.Grip"', POSITION)
    device = VirtualDevice(open_plan(written(tmp_path, PLAIN_DBC, text)))
    codec = MappedCodec(open_plan(tmp_path / "hand.toml"))
    found = []
    for tick in range(1, 20):
        now = tick * NS // 200
        device.sense(FingertipState(now, "thumb", tick, **FELT))
        found += [each for frame in device.due(now) for each in codec.decode_all(frame)]
    assert found[-1].normal_force == pytest.approx(2.0)
    assert found[-1].displacement == pytest.approx(1.2e-3)
    assert [state.seq for state in found] == list(range(found[0].seq, found[0].seq + len(found)))
    for frame in codec.encode(ForceCommand(now, "thumb", 1, 3.5, 0.0, Reason.RAISE, now + NS)):
        device.take_in(frame, now)
    assert device.taken() == [("thumb", pytest.approx(3.5, abs=0.02))]
    assert device.taken() == []


@pytest.mark.parametrize("length", [9, 10, 11, 13, 17, 21, 25, 33, 49])
def test_a_frame_of_a_length_that_can_fd_has_not_leaves_filled_up_and_is_understood(length, tmp_path):
    dbc = PLAIN_DBC.replace("BO_ 512 Set1: 8 X", f"BO_ 512 Set1: {length} X")
    opening = f'device.opening = [{{ identifier = 9, data = "{"7F" * length}" }}]\nrate = 200.0'
    path = written(tmp_path, dbc, PLAIN_MAP.replace("rate = 200.0", opening))
    device, codec = VirtualDevice(open_plan(path)), MappedCodec(open_plan(path))
    device.sense(FingertipState(0, "thumb", 1, **FELT))
    assert device.due(NS) == []
    said = codec.due(NS)
    given = codec.encode(ForceCommand(NS, "thumb", 1, 3.5, 0.0, Reason.RAISE, 2 * NS))
    for frame in (*said, *given):
        assert frame.fd
        assert pack_request(0, frame.arbitration_id, frame.data, PLAIN_FLAGS)
        device.take_in(frame, NS)
    assert (len(said), len(given)) == (1, 1)
    assert device.due(2 * NS)
    assert device.taken() == [("thumb", pytest.approx(3.5))]


POSITION = """signal = "Set1.Grip"
kind = "position"
stiffness = "2 N/mm"
unit = "mm"
feedback = "Pos1.Depth\""""
