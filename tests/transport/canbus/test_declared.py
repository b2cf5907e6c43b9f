"""What a virtual bus and a traffic plan may be asked for: default and bounds of every setting."""

import dataclasses
import math
from typing import Any

import pytest

from vegrip.transport.canbus.bus_events import NodeFaults
from vegrip.transport.canbus.frame_time import BitTiming
from vegrip.transport.canbus.hub_wire import Greeting
from vegrip.transport.canbus.traffic import TrafficPlan

SHARE = (0.0, 0.0, 1.0)
DECLARED: dict[type[Any], dict[str, tuple[float, float, float]]] = {
    BitTiming: {"bitrate": (1e6, 1e3, 2e7), "data_bitrate": (5e6, 1e3, 2e7)},
    Greeting: {"patience": (-1.0, -1.0, 0.1)},
    NodeFaults: {
        "loss": SHARE, "corruption": SHARE, "misreading": SHARE, "flips": SHARE,
        "delay": (0.0, 0.0, 10.0), "jitter": (0.0, 0.0, 10.0),
        "babble": (-1, -1, 0x7FF), "seed": (0, 0, math.inf),
    },
    TrafficPlan: {
        "fingers": (5, 1, 8), "hands": (1, 1, 8), "state_parts": (2, 1, 3),
        "rate": (500.0, 0.1, 1e4), "report_rate": (50.0, 0.0, 1e4), "health_rate": (5.0, 0.0, 1e4),
        "status_rate": (1.0, 0.0, 100.0), "jitter": (0.0, 0.0, 1.0),
        "bitrate": (1e6, 1e4, 1e6), "data_bitrate": (5e6, 1e4, 1e7),
    },
}  # fmt: skip


@pytest.mark.parametrize("cls", DECLARED)
def test_settings_have_these_defaults_and_bounds(cls: type[Any]) -> None:
    found = {f.name: (f.default, f.metadata["parameter"]) for f in dataclasses.fields(cls)}
    bounded = {
        name: (default, of.low, of.high) for name, (default, of) in found.items() if of.low > -math.inf
    }
    assert bounded == DECLARED[cls]


def test_switches_are_off_but_for_the_layout_of_fd() -> None:
    on = {f.name for cls in DECLARED for f in dataclasses.fields(cls) if f.default is True}
    assert on == {"fd"}
