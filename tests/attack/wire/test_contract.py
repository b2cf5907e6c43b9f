"""What ``proto/README.md`` says of codes and bytes is what the codec does."""

import re
from enum import IntEnum, IntFlag
from pathlib import Path

import pytest

from vegrip.messages import Channel, Condition, FingertipState, Lifecycle, Reason
from vegrip.transport.codec import CanCodec, Frame, MsgpackCodec

TEXT = (Path(__file__).parents[3] / "proto/README.md").read_text()
STATE = FingertipState(stamp=10**9, finger="thumb", seq=7, normal_force=4.0)


def example(name: str) -> tuple[str, bytes]:
    found = re.search(rf"^{name} +(\S+) +([0-9a-f]+)$", TEXT, re.MULTILINE)
    assert found
    return found[1], bytes.fromhex(found[2])


@pytest.mark.parametrize("name", ["classic", "fd"])
def test_the_frame_in_the_contract_is_the_one_that_is_sent(name: str) -> None:
    identifier, data = example(name)
    sent = CanCodec(("thumb",), fd=name == "fd").encode(STATE)
    assert [(f.arbitration_id, f.data) for f in sent] == [(int(identifier, 16), data)]
    frame = Frame(int(identifier, 16), data, fd=name == "fd", stamp=1)
    decoded = CanCodec(("thumb",), fd=name == "fd").decode(frame)
    assert isinstance(decoded, FingertipState)
    assert decoded.normal_force == 4.0


def test_the_payload_in_the_contract_is_the_one_that_is_sent() -> None:
    topic, data = example("msgpack")
    assert MsgpackCodec("left", ("thumb",)).encode(STATE) == (topic, data)


@pytest.mark.parametrize("codes", [Reason, Condition, Lifecycle, Channel])
def test_the_codes_in_the_contract_are_those_of_the_messages(codes: type[IntEnum] | type[IntFlag]) -> None:
    row = re.search(rf"^\| `{codes.__name__}` \| (.*) \|$", TEXT, re.MULTILINE)
    assert row
    told = {name: int(code) for code, name in re.findall(r"(\d+) (\w+)", row[1])}
    assert told == {name.lower(): int(member) for name, member in codes.__members__.items()}
