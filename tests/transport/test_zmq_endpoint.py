"""Laws of the ZeroMQ endpoint."""

import contextlib
import socket
import time
from pathlib import Path

import pytest
import zmq

from vegrip.errors import ConfigError, DeviceError
from vegrip.messages import FingertipState, Lifecycle, NodeStatus
from vegrip.transport.codec.msgpack_codec import MsgpackCodec
from vegrip.transport.curve import Curve, Keys, resolve
from vegrip.transport.key_files import make_keys
from vegrip.transport.open import Hand, open_endpoint
from vegrip.transport.zmq_endpoint import MAX_MESSAGE_BYTES, MOST_MESSAGES, ZmqEndpoint

FINGERS = ("thumb", "index")
pytestmark = pytest.mark.usefixtures("runtime")


@pytest.fixture
def endpoint():
    opened = []

    def open_one(publish="", subscribe=(), **options):
        codec = MsgpackCodec(options.pop("namespace", ""), FINGERS, remap=options.pop("remap", None))
        opened.append(ZmqEndpoint(publish, subscribe, codec, **options))
        return opened[-1]

    yield open_one
    for each in opened:
        each.close()


def state(seq, force=1.25):
    return FingertipState(stamp=time.monotonic_ns(), finger="index", seq=seq, normal_force=force)


def first_message(sender, receiver, tries=400):
    """Send until something arrives: a subscription takes a moment."""
    for seq in range(tries):
        sender.send(state(seq))
        if got := receiver.receive(0.01):
            return got[0]
    return None


@pytest.mark.parametrize("address", ["ipc:hand", "tcp://127.0.0.1:0"])
def test_messages_go_through(endpoint, address):
    sender = endpoint(address)
    at = sender._publisher.getsockopt(zmq.LAST_ENDPOINT).decode().rstrip("\0")
    got = first_message(sender, endpoint("", [at]))
    assert (got.finger, got.normal_force) == ("index", 1.25)


def test_a_message_is_seen_within_the_wait_not_at_its_end(endpoint):
    sender, receiver = endpoint("ipc:hand"), endpoint("", ["ipc:hand"])
    first_message(sender, receiver)
    receiver.receive(0.05)
    sender.send(state(1000))
    start = time.monotonic()
    assert len(receiver.receive(5.0)) == 1
    assert time.monotonic() - start < 1.0
    assert len(receiver.arrivals) == 1


def test_the_time_out_is_finer_than_a_millisecond(endpoint):
    receiver = endpoint("", ["ipc:nobody"])
    start = time.monotonic()
    for _ in range(10):
        assert receiver.receive(0.0004) == []
    assert 0.004 <= time.monotonic() - start < 0.5


def test_the_order_of_starting_does_not_matter(endpoint):
    receiver = endpoint("", ["ipc:later"])
    assert first_message(endpoint("ipc:later"), receiver) is not None


def test_hands_in_different_namespaces_do_not_hear_each_other(endpoint):
    left, right = endpoint("ipc:left", namespace="left"), endpoint("ipc:right", namespace="right")
    node = endpoint("", ["ipc:left", "ipc:right"], namespace="left")
    assert first_message(right, node, tries=30) is None
    assert first_message(left, node) is not None
    assert set(node.rejected) >= {"unknown_topic"}


def test_a_remapped_topic_travels_under_its_other_name(endpoint):
    names = {"/hand/index/state": "/gripper/left/state"}
    sender = endpoint("ipc:hand", remap=names)
    plain = endpoint("", ["ipc:hand"])
    remapped = endpoint("", ["ipc:hand"], remap=names)
    assert first_message(sender, remapped).finger == "index"
    plain.receive(0.05)
    assert plain.rejected["unknown_topic"] > 0


def test_an_address_in_use_is_one_sentence(endpoint):
    first = endpoint("tcp://127.0.0.1:0")
    taken = first._publisher.getsockopt(zmq.LAST_ENDPOINT).decode().rstrip("\0")
    with pytest.raises(DeviceError, match="in use"):
        endpoint(taken)


def test_rubbish_is_counted_by_name_and_what_is_too_long_never_arrives(endpoint):
    receiver = endpoint("", ["ipc:rubbish"])
    with zmq.Context() as context, context.socket(zmq.PUB) as sender:
        sender.linger = 0
        sender.bind(resolve("ipc:rubbish"))
        for _ in range(500):
            sender.send_multipart([b"/hand/index/state"])
            sender.send_multipart([b"/hand/index/state", b"\xff" * 40])
            sender.send_multipart([b"\xff\xfe", b"x"])
            receiver.receive(0.005)
            if receiver.rejected.get("parts"):
                break
        receiver.receive(0.01)
        before = dict(receiver.rejected)
        assert {"parts", "checksum", "unknown_topic"} <= set(before)
        sender.send_multipart([b"/hand/index/state", bytes(MAX_MESSAGE_BYTES + 1)])
        assert receiver.receive(0.1) == []
        assert {**receiver.rejected, "cut_off": 0} == {**before, "cut_off": 0}


@pytest.fixture
def keys(tmp_path):
    (tmp_path / "peers").mkdir()
    for name in ("hand", "node", "stranger"):
        make_keys(tmp_path, name)
    for name in ("hand", "node"):
        (tmp_path / "peers" / f"{name}.key").write_bytes((tmp_path / f"{name}.key").read_bytes())

    def of(name, publisher):
        own, peer = tmp_path / f"{name}.key_secret", tmp_path / f"{publisher}.key"
        return Keys(Curve(own=str(own), peers=str(tmp_path / "peers"), publisher=str(peer)))

    return of


def test_with_keys_those_who_know_each_other_talk_and_strangers_hear_nothing(endpoint, keys):
    hand = endpoint("tcp://127.0.0.1:0", keys=keys("hand", "node"))
    at = hand._publisher.getsockopt(zmq.LAST_ENDPOINT).decode().rstrip("\0")
    node = endpoint("", [at], keys=keys("node", "hand"))
    stranger = endpoint("", [at], keys=keys("stranger", "hand"))
    unencrypted = endpoint("", [at])
    assert first_message(hand, node) is not None
    assert first_message(hand, stranger, tries=20) is None
    assert first_message(hand, unencrypted, tries=20) is None


def test_an_impostor_at_the_address_of_the_hand_is_not_heard(endpoint, keys):
    impostor = endpoint("tcp://127.0.0.1:0", keys=keys("stranger", "node"))
    at = impostor._publisher.getsockopt(zmq.LAST_ENDPOINT).decode().rstrip("\0")
    node = endpoint("", [at], keys=keys("node", "hand"))
    assert first_message(impostor, node, tries=30) is None


def test_a_key_file_that_is_none_is_one_sentence(keys, tmp_path):
    (tmp_path / "bad").write_text("nothing")
    for own in ("absent", "bad", "hand.key"):
        with pytest.raises(ConfigError, match="key"):
            Keys(
                Curve(
                    own=str(tmp_path / own),
                    peers=str(tmp_path / "peers"),
                    publisher=str(tmp_path / "hand.key"),
                )
            )


def test_an_endpoint_is_made_from_a_table():
    hand = Hand(FINGERS, namespace="left")
    one = open_endpoint({"kind": "zmq", "publish": "ipc:a", "subscribe": ["ipc:b"]}, hand)
    other = open_endpoint({"kind": "zmq", "publish": "ipc:b", "subscribe": ["ipc:a"]}, hand)
    assert first_message(one, other) is not None
    one.close()
    other.close()


def heard_after(seconds, receiver, send):
    """Whether ``receiver`` hears what ``send(seq)`` sends again and again; gives up after ``seconds``."""
    end = time.monotonic() + seconds
    seq = 10_000
    while time.monotonic() < end:
        send(seq)
        if receiver.receive(0.01):
            return True
        seq += 1
    return False


@pytest.fixture
def publisher():
    with zmq.Context() as context, context.socket(zmq.PUB) as socket:
        socket.linger = 0
        yield socket


@pytest.mark.parametrize("address", ["ipc:large", "tcp://127.0.0.1:*"])
def test_a_message_that_is_too_long_is_counted_and_the_next_ones_are_heard(endpoint, publisher, address):
    publisher.bind(resolve(address))
    at = publisher.getsockopt(zmq.LAST_ENDPOINT).decode().rstrip("\0")
    receiver = endpoint("", [at])
    codec = MsgpackCodec()

    def send(seq):
        topic, payload = codec.encode(state(seq))
        publisher.send_multipart([topic.encode(), payload])

    for times in (1, 2, 3):
        assert heard_after(20.0, receiver, send)
        publisher.send_multipart([b"/hand/index/state", bytes(MAX_MESSAGE_BYTES + 1)])
        deadline = time.monotonic() + 20.0
        while receiver.rejected.get("cut_off", 0) < times and time.monotonic() < deadline:
            receiver.receive(0.01)
        assert receiver.rejected["cut_off"] == times
    assert heard_after(20.0, receiver, send)


def test_bytes_that_are_no_zeromq_end_no_subscription(endpoint):
    """The publisher greets as it should, then sends a frame that cannot be."""
    path = resolve("ipc:wrong").removeprefix("ipc://")
    receiver = endpoint("", ["ipc:wrong"])
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(path)
        listener.listen()
        listener.settimeout(0.01)
        came = []
        end = time.monotonic() + 20.0
        while len(came) < 2 and time.monotonic() < end:
            receiver.receive(0.01)
            with contextlib.suppress(TimeoutError):
                came.append(listener.accept()[0])
                came[-1].sendall(GREETING + READY)
                came[-1].sendall(b"\xff" * 16)
    for each in came:
        each.close()
    assert len(came) == 2, "it came again"
    Path(path).unlink()
    sender = endpoint("ipc:wrong")
    assert heard_after(20.0, receiver, lambda seq: sender.send(state(seq)))
    assert receiver.rejected["cut_off"] >= 1


GREETING = b"\xff" + bytes(8) + b"\x7f\x03\x00" + b"NULL".ljust(20, b"\0") + bytes(32)
READY = b"\x04\x19\x05READY\x0bSocket-Type\x00\x00\x00\x03PUB"


def test_one_who_holds_the_place_of_a_publisher_in_silence_is_left_for_the_true_one(endpoint):
    path = resolve("ipc:silent").removeprefix("ipc://")
    receiver = endpoint("", ["ipc:silent"])
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(path)
        listener.listen()
        held, _ = listener.accept()
    Path(path).unlink()
    sender = endpoint("ipc:silent")
    with held:
        assert heard_after(20.0, receiver, lambda seq: sender.send(state(seq)))


def test_a_publisher_that_leaves_and_comes_back_is_not_counted_as_cut_off(endpoint):
    receiver = endpoint("", ["ipc:comes"])
    for _ in range(3):
        sender = endpoint("ipc:comes")
        assert heard_after(20.0, receiver, lambda seq, sender=sender: sender.send(state(seq)))
        sender.close()
        receiver.receive(0.3)
    assert "cut_off" not in receiver.rejected


def test_of_several_publishers_each_is_heard(endpoint):
    senders = {name: endpoint(f"ipc:{name}") for name in ("a", "b", "c")}
    receiver = endpoint("", [f"ipc:{name}" for name in senders])
    heard = set()
    end = time.monotonic() + 20.0
    while len(heard) < 3 and time.monotonic() < end:
        for name, sender in senders.items():
            sender.send(NodeStatus(time.monotonic_ns(), name, 0, Lifecycle.ACTIVE))
        heard |= {message.node for message in receiver.receive(0.01)}
    assert heard == set(senders)


def test_a_flood_that_is_answered_past_the_messages_keeps_nobody_from_the_next_tick(endpoint, monkeypatch):
    taken = []
    listener = endpoint("", ["ipc:flood"])
    monkeypatch.setattr(listener._subscriptions[0], "take", lambda: (b"topic", b"payload"))
    monkeypatch.setattr(listener, "_take", lambda parts, *_: taken.append(parts))
    assert not listener.receive(0.0)
    assert len(taken) == MOST_MESSAGES
