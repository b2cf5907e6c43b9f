"""Each map in the box, live against a device that speaks so: read, cut off, reset, given wrong lengths."""

import math
import time

import can
import pytest

from tests.transport.hands.devices import (
    CAN_DEVICES,
    DEVICES,
    NORMAL,
    TORQUE,
    Hex,
    Inspire,
    Papillarray,
    Paxini,
    Tesollo,
    X,
    Y,
)
from vegrip.clock import NS
from vegrip.errors import ConfigError, DeviceError
from vegrip.messages import DeviceReport, FingertipState, ForceCommand, Reason
from vegrip.transport.hands import link_endpoint
from vegrip.transport.hands.endpoints import MappedCanEndpoint
from vegrip.transport.mapped.codec import MappedCodec
from vegrip.transport.mapped.plan import open_plan
from vegrip.transport.maps import dialogue
from vegrip.transport.maps.map_text import changed_text
from vegrip.transport.maps.products import about, map_of, names
from vegrip.transport.open import Hand, open_endpoint

PATIENCE = 20.0  # [s] on a busy machine


@pytest.fixture(autouse=True)
def _impatient(monkeypatch):
    monkeypatch.setattr(link_endpoint, "REOPEN_PERIOD", NS // 100)
    monkeypatch.setattr(dialogue, "SILENT_AFTER", NS // 10)


def map_with(folder, name, settings):
    path = folder / f"{name}.toml"
    path.write_text(changed_text(map_of(name).read_text(), list(settings)))
    return path


def until(device, endpoint, done, harm=lambda packet: packet):
    """Let both work until ``done`` says so of all states that have come since; return those."""
    states, end = [], time.monotonic() + PATIENCE
    while time.monotonic() < end:
        device.step(harm)
        states += endpoint.receive(0.002)
        assert len(endpoint.arrivals) <= len(states)
        if done(states):
            return states
    raise AssertionError(f"{len(states)} states, {dict(endpoint.rejected)}")


def several(states):
    return len(states) >= 5


@pytest.fixture(params=DEVICES, ids=lambda device: device.name)
def pair(request, tmp_path):
    device = request.param(tmp_path)
    path = map_with(tmp_path, device.name, device.settings)
    plan = open_plan(path)
    settings = {key: value for key, value in plan.hand.transport.items() if key not in ("kind", "address")}
    hand = Hand(tuple(plan.hand.fingers))
    endpoint = open_endpoint(device.port.kind, hand, map=str(path), address=device.port.address, **settings)
    with endpoint:
        yield device, endpoint
    device.port.close()


def check(states, fingers):
    last = {state.finger: state for state in states if isinstance(state, FingertipState)}
    assert set(last) == set(fingers)
    step = 0.06  # [N] half of the coarsest
    for state in last.values():
        assert state.normal_force == pytest.approx(NORMAL, abs=step)
        if not math.isnan(state.tangential_force_x):
            assert state.tangential_force_x == pytest.approx(X, abs=step)
            assert state.tangential_force_y == pytest.approx(Y, abs=step)
        if not math.isnan(state.torque_z):
            assert state.torque_z == pytest.approx(TORQUE, abs=1e-6)


def test_a_device_is_opened_asked_and_read(pair):
    device, endpoint = pair
    states = until(device, endpoint, several)
    check(states, about(device.name)["fingers"])
    states = [state for state in states if isinstance(state, FingertipState)]
    assert all(after.stamp >= before.stamp for before, after in zip(states, states[5:], strict=False))
    assert not endpoint.rejected.keys() & {"link_lost", "bad_checksum", "unsent"}


def test_a_cable_that_is_cut_is_counted_and_the_device_is_found_again(pair):
    device, endpoint = pair
    until(device, endpoint, several)
    device.port.cut()
    for _ in range(30):
        endpoint.receive(0.001)
    device.reset()
    device.port.plug()
    check(until(device, endpoint, several), about(device.name)["fingers"])
    assert endpoint.rejected.keys() & {"link_lost", "silent", "unanswered"}


def test_a_device_that_is_reset_is_opened_again(pair):
    device, endpoint = pair
    until(device, endpoint, several)
    device.reset()
    check(until(device, endpoint, several), about(device.name)["fingers"])


def test_packets_of_a_wrong_length_are_counted_and_no_states(pair):
    device, endpoint = pair
    until(device, endpoint, several)
    found = []
    for _ in range(20):
        device.step(lambda packet: packet[:-1])
        found += endpoint.receive(0.002)
    assert len(found) <= 1 or not device.is_protected
    states = until(device, endpoint, several)
    assert states
    counted = {"bad_checksum", "short", "bad_end", "bad_record", "unanswered", "resync", "silent"}
    assert endpoint.rejected.keys() & counted


@pytest.mark.parametrize("pair", [Hex, Paxini, Papillarray, Tesollo], indirect=True, ids=lambda one: one.name)
def test_a_device_takes_its_own_zero_when_told_to(pair):
    device, endpoint = pair
    until(device, endpoint, several)
    assert endpoint.zero()
    until(device, endpoint, lambda _: device.zeros == 1)
    until(device, endpoint, several)
    assert device.zeros == 1


@pytest.mark.parametrize("pair", [Papillarray], indirect=True, ids=lambda one: one.name)
def test_what_a_device_says_of_its_contact_comes_beside_its_states(pair):
    device, endpoint = pair

    def reports(found):
        return [one for one in found if isinstance(one, DeviceReport)]

    first = reports(until(device, endpoint, reports))
    assert all(math.isnan(one.friction) for one in first)  # -1 is none
    device.friction = 0.75
    found = until(device, endpoint, lambda found: len(reports(found)) > 6)
    assert {one.finger for one in reports(found)} == {"first", "second"}
    last = reports(found)[-1]
    assert (last.slip_state, last.friction, last.grip_force) == (2.0, 0.75, 3.5)
    states = [one for one in found if isinstance(one, FingertipState)]
    assert len(reports(found)) < len(states)
    assert all(math.isnan(one.slip) for one in states)  # nothing rests on it


@pytest.mark.parametrize("pair", [Inspire], indirect=True, ids=lambda one: one.name)
def test_a_hand_on_modbus_is_written_the_force_of_each_finger(pair):
    device, endpoint = pair
    until(device, endpoint, several)
    for count, finger in enumerate(("little", "ring", "middle", "index", "thumb"), 1):
        endpoint.send(ForceCommand(0, finger, 1, float(count), 0.0, Reason.RAISE, 1 << 62))
    written = (100, 200, 300, 400, 500)
    until(device, endpoint, lambda _: written in device.heard)
    assert "unknown_packet" not in endpoint.rejected


@pytest.mark.parametrize("pair", [Paxini], indirect=True, ids=lambda one: one.name)
def test_one_question_is_out_at_a_time_and_one_without_answer_is_counted(pair, monkeypatch):
    device, endpoint = pair
    monkeypatch.setattr(dialogue, "SILENT_AFTER", 60 * NS)
    until(device, endpoint, several)
    device.hear = lambda *_: None
    before = len(device.heard)
    until(device, endpoint, lambda _: endpoint.rejected.get("unanswered", 0) >= 3)
    assert len(device.heard) - before <= endpoint.rejected["unanswered"] + 1
    assert all(len(request) == 14 for request in device.heard)


@pytest.fixture(params=CAN_DEVICES, ids=lambda device: device.name)
def can_pair(request, tmp_path):
    device = request.param(request.param.name)
    codec = MappedCodec(open_plan(map_with(tmp_path, device.name, device.settings)))
    with MappedCanEndpoint(can.Bus(interface="virtual", channel=device.name), codec) as endpoint:
        yield device, endpoint
    device.bus.shutdown()


def test_a_hand_on_can_is_opened_asked_and_read(can_pair):
    device, endpoint = can_pair
    states = []
    end = time.monotonic() + PATIENCE
    while len(states) <= 5 * device.fingers and time.monotonic() < end:
        states += endpoint.receive(0.002)
        device.step()
    check(states[-device.fingers :], about(device.name)["fingers"])
    assert "unanswered" not in endpoint.rejected


def test_every_product_says_where_it_is_from_and_that_nobody_has_tried_it():
    tested = {device.name for device in (*DEVICES, *CAN_DEVICES)}
    feeling = [name for name in names() if about(name)["channels"]]
    assert set(feeling) == tested
    for name in feeling:
        told = about(name)
        assert " at " in told["source"] or told["source"].startswith("pyrobotiqtactile")
        assert told["tried_on"] == []
        assert "normal_force" in told["channels"]
        if (
            told["to_measure"]
            and told["to_measure"] != ["command.gain"]
            and "command.signal" not in told["to_measure"]
        ):
            with pytest.raises(ConfigError, match="is not known"):
                open_plan(map_of(name))


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"kind": "serial", "address": "/dev/nothing"}, "there is no such file"),
        ({"kind": "serial", "address": "/dev/null"}, "it is no serial line"),
        ({"kind": "serial", "address": ""}, "state where the device is"),
        ({"kind": "serial", "address": "/dev/null", "baud": 12345}, "no such rate"),
        ({"kind": "tcp", "address": "127.0.0.1:1"}, "nothing listens there"),
        ({"kind": "tcp", "address": "127.0.0.1"}, "must be HOST:PORT"),
        ({"kind": "udp", "address": ["127.0.0.1:9", "127.0.0.1:9"]}, "has 1 devices, so give 1"),
    ],
)
def test_a_device_that_cannot_be_opened_is_told_in_one_sentence(settings, said, tmp_path):
    path = map_with(tmp_path, "bota-sensone", ())
    with pytest.raises((ConfigError, DeviceError), match=said) as caught:
        open_endpoint({**settings, "map": str(path)}, Hand(("tip",)))
    assert "\n" not in str(caught.value)


def test_a_port_that_another_has_is_told(tmp_path):
    from devices import Pty

    port = Pty(tmp_path)
    path = map_with(tmp_path, "bota-sensone", ())
    settings = {"kind": "serial", "address": port.address, "map": str(path)}
    with open_endpoint(settings, Hand(("tip",))), pytest.raises(DeviceError, match="another program has it"):
        open_endpoint(settings, Hand(("tip",)))
    port.close()
