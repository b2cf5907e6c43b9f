"""A SocketCAN interface that is set to another bit rate is refused before anything disturbs the bus."""

import json

import can
import pytest

from vegrip.transport.can_port import check_rates


def link(**data):
    return json.dumps([{"ifname": "can0", "linkinfo": {"info_kind": "can", "info_data": data}}])


CLASSIC = {"bittiming": {"bitrate": 500_000}}
BOTH = {"bittiming": {"bitrate": 1_000_000}, "data_bittiming": {"bitrate": 2_000_000}}


@pytest.mark.parametrize(
    ("said", "fd", "sentence"),
    [
        (link(**CLASSIC), False, r"it is set to 500000 bit/s, not 1000000; set transport.bitrate to what"),
        (
            link(**BOTH),
            True,
            r"1000000 and 2000000 bit/s, not 1000000 and 5000000; set transport.bitrate and",
        ),
    ],
)
def test_other_rates_are_refused_with_the_remedy(said, fd, sentence):
    with pytest.raises(can.CanInitializationError, match=sentence) as caught:
        check_rates("can0", 1_000_000, 5_000_000, fd=fd, ask=lambda _: said)
    assert "sudo ip link set can0 type can bitrate 1000000" in str(caught.value)


@pytest.mark.parametrize("said", [link(**BOTH), link(), "[]", "", "nonsense", '[{"ifname": "vcan0"}]'])
def test_the_right_rates_and_what_has_none_pass(said):
    check_rates("can0", 1_000_000, 2_000_000, fd=True, ask=lambda _: said)
