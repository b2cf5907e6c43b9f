"""Bytes from outside never raise: the parsers that the tests of the codec do not reach."""

from collections import Counter
from types import SimpleNamespace

import msgpack
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vegrip.canopen.endpoint import CanopenCodec
from vegrip.canopen.network import finger_nodes, identifiers
from vegrip.runtime.control_socket import Answers
from vegrip.transport.codec import CanCodec, Frame

FINGERS = ("thumb", "index")


@given(st.integers(0, 0x7FF), st.binary(max_size=8))
def test_any_frame_on_a_canopen_bus_is_refused_by_name_or_left_to_the_services(identifier, data):
    left = []
    codec = CanCodec(FINGERS, fd=False)
    end = SimpleNamespace(service=left.append, hears=lambda _: True)
    pdos = CanopenCodec(codec, identifiers(finger_nodes(32, 0, 2), 16, 0), end)
    assert pdos.decode(Frame(identifier, data)) is None
    assert len(left) + codec.rejected.total() == 1


scalars = st.none() | st.booleans() | st.integers(-(2**63), 2**64 - 1) | st.floats() | st.text() | st.binary()
objects = st.recursive(
    scalars, lambda inner: st.lists(inner, max_size=4) | st.dictionaries(scalars, inner, max_size=4)
)


@pytest.fixture(scope="module")
def answers():
    return Answers({"state": lambda: {"state": "active"}}, Counter())


@given(st.lists(st.binary(max_size=200) | objects.map(msgpack.packb), max_size=3))
def test_any_request_to_a_node_is_answered(answers, frames):
    assert set(msgpack.unpackb(answers.answer(frames))) & {"result", "error"}


@given(objects, objects)
def test_any_call_and_any_arguments_are_answered(answers, call, arguments):
    answer = answers.answer([msgpack.packb({"call": call, "arguments": arguments})])
    assert set(msgpack.unpackb(answer)) & {"result", "error"}


def test_a_result_that_cannot_be_sent_is_an_error_and_no_end():
    counts = Counter()
    answers = Answers({"odd": lambda: "\udc80"}, counts)
    assert "error" in msgpack.unpackb(answers.answer([msgpack.packb({"call": "odd"})]))
    assert counts == {"request": 1}
