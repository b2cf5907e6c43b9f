"""What a drive can do is data, and what no drive can be is refused in one sentence."""

import math
from pathlib import Path

import pytest

from vegrip.config import build
from vegrip.errors import ConfigError
from vegrip.grip.safety.drive import DriveLimits
from vegrip.transport.maps.schema import parse_map

HAND = {"packets": {"p": {"start": "AA", "length": 6, "fields": {"f": "f32 le @2 * 1 N"}}}}
FINGERS = {"fingers": {"left": {"normal_force": {"signal": "p.f"}}}}


def test_a_map_that_says_nothing_of_its_drive_sets_no_limit():
    drive = parse_map(HAND | FINGERS, Path("hand.toml")).drive
    assert drive == DriveLimits(0.0, 0.0, 0.0, 0.0, math.inf, 0.0)


def test_a_map_says_what_its_drive_can_do():
    told = {"resolution": 0.8, "rate": 50.0, "delay": 0.03, "minimum": 20.0, "maximum": 235.0}
    drive = parse_map(HAND | FINGERS | {"drive": told | {"hysteresis": 2.0}}, Path("hand.toml")).drive
    assert drive == DriveLimits(0.8, 50.0, 0.03, 20.0, 235.0, 2.0)


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({"resolution": -1.0}, "'resolution'"),
        ({"rate": -1.0}, "'rate'"),
        ({"delay": -0.1}, "'delay'"),
        ({"delay": math.nan}, "'delay'"),
        ({"hysteresis": -0.1}, "'hysteresis'"),
        ({"minimum": 30.0, "maximum": 20.0}, "the least force must be below the largest"),
        ({"minimum": 20.0, "maximum": 20.0}, "the least force must be below the largest"),
        ({"minimum": 20.0, "maximum": 30.0, "resolution": 11.0}, "only 10 N"),
        ({"maximum": 30.0, "hysteresis": 31.0}, "only 30 N"),
        ({"serves": ["left"]}, "unknown key 'serves'"),
    ],
)
def test_what_no_drive_can_be_is_refused_in_one_sentence(table, said):
    with pytest.raises(ConfigError) as refused:
        parse_map(HAND | FINGERS | {"drive": table}, Path("hand.toml"))
    text = str(refused.value)
    assert said in text
    assert text.startswith("hand.toml")
    assert "\n" not in text


def test_the_edge_is_allowed_where_one_step_leads_from_end_to_end():
    drive = build(DriveLimits, {"minimum": 20.0, "maximum": 30.0, "resolution": 10.0}, "drive")
    assert drive.maximum - drive.minimum == drive.resolution
