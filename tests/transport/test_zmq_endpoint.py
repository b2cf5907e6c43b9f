"""Laws of the ZeroMQ endpoint."""

import time

import pytest
import zmq

from vegrip.codec.msgpack_codec import MsgpackCodec
from vegrip.errors import ConfigError, DeviceError
from vegrip.messages import FingertipState
from vegrip.transport.curve import Curve, Keys
from vegrip.transport.key_files import make_keys
from vegrip.transport.open import Hand, open_endpoint
from vegrip.transport.zmq_endpoint import LARGEST, ZmqEndpoint

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


def test_rubbish_is_counted_and_what_is_too_long_never_arrives(endpoint):
    receiver = endpoint("", ["ipc:rubbish"])
    from vegrip.transport.zmq_address import resolve

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
        sender.send_multipart([b"/hand/index/state", bytes(LARGEST + 1)])
        assert receiver.receive(0.1) == []
        assert dict(receiver.rejected) == before


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
