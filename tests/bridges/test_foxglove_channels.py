"""Laws of the two encodings: both carry what the recorder writes, and readers of others read it."""

import json
import math

import pytest

from tests.bridges.messages_of_a_hand import SENT
from vegrip.bridges.foxglove_channels import Cdr, Json
from vegrip.messages import FingertipState

KINDS = [type(message).__name__ for message in SENT]


@pytest.mark.parametrize("message", SENT, ids=KINDS)
def test_a_reader_of_ros_bags_reads_from_cdr_what_json_says(message) -> None:
    store, name = typed(Cdr().channel(1, "/t", type(message)))
    read = store.deserialize_cdr(Cdr().message(message, 0), name)
    row = json.loads(Json().message(message, 0))
    fields = json.loads(Json().channel(1, "/t", type(message))["schema"])["properties"]
    assert row.keys() <= fields.keys()
    for field in fields:
        value = getattr(read, field)
        if isinstance(value, str):
            assert value == row.get(field, "")
        else:
            assert value == row.get(field) or (math.isnan(value) and field not in row)


def test_the_bytes_are_those_that_a_writer_of_ros_bags_makes() -> None:
    for message in SENT:
        store, name = typed(Cdr().channel(1, "/t", type(message)))
        data = Cdr().message(message, 0)
        assert bytes(store.serialize_cdr(store.deserialize_cdr(data, name), name)) == data


def test_a_line_of_the_log_has_level_time_and_text_in_both_encodings() -> None:
    stamp = 1_700_000_000_000_000_005
    store, name = typed(Cdr().log_channel(0, "/log"))
    read = store.deserialize_cdr(Cdr().log(stamp, "error", "thumb", "slips"), name)
    row = json.loads(Json().log(stamp, "error", "thumb", "slips"))
    assert (read.timestamp.sec, read.timestamp.nanosec) == (1_700_000_000, 5)
    assert row["timestamp"] == {"sec": 1_700_000_000, "nsec": 5}
    assert (read.level, read.message, read.name, read.line) == (4, "slips", "thumb", 0)
    assert (row["level"], row["message"], row["name"], row["line"]) == (4, "slips", "thumb", 0)


def test_a_level_is_that_of_the_maker() -> None:
    foxglove = pytest.importorskip("foxglove.messages")
    for level in ("info", "warning", "error"):
        row = json.loads(Json().log(0, level, "", ""))
        assert row["level"] == {"info": 2, "warning": 3, "error": 4}[level]
        assert hasattr(foxglove.LogLevel, level.title())


def test_a_cdr_definition_states_the_unit_of_every_number() -> None:
    lines = Cdr().channel(1, "/t", FingertipState)["schema"].splitlines()
    assert "float64 normal_force  # [N]" in lines
    assert "float64 displacement  # [m]" in lines
    assert all(line.endswith("]") for line in lines if line.startswith("float64"))


def typed(channel):
    typesys = pytest.importorskip("rosbags.typesys")
    store = typesys.get_typestore(typesys.Stores.EMPTY)
    store.register(typesys.get_types_from_msg(channel["schema"], channel["schemaName"]))
    return store, channel["schemaName"]
