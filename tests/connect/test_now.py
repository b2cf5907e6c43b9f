"""What a hand sends just now, as a terminal shows it while one listens: in its units, and by a map in SI."""

import math

import pytest

from tests.transport.maps.hands import PLAIN_DBC, PLAIN_MAP, load, written
from vegrip.connect.traffic import MappedNow, SignalsNow
from vegrip.transport.codec import Frame
from vegrip.transport.mapped.plan import open_plan
from vegrip.transport.maps.database import read_dbc

MAP = PLAIN_MAP.replace('checksum = { kind = "crc8"', '# { kind = "crc8"')


def frame(name, identifier, **values):
    data = load(PLAIN_DBC).encode_message(name, values, strict=False)
    return Frame(identifier, data, False, 1)


def tip(fz):
    return frame("Tip1", 256, Fz=fz, Fx=0.5, Fy=0.0, Cnt=1, Crc=0)


def test_signals_that_may_be_a_fingertip_s_are_shown_in_their_units(tmp_path):
    written(tmp_path, PLAIN_DBC, MAP)
    now = SignalsNow(read_dbc(tmp_path / "plain.dbc"))
    assert all(math.isnan(value) for _, _, value, _ in now.rows())
    now.update(tip(-2.5))
    now.update(frame("Pos1", 272, Depth=1.25, Tz=0.0, Slip=0))
    now.update(Frame(256, b"\x01", False, 2))  # too short
    now.update(Frame(999, bytes(8), False, 2))
    shown = {f"{source}.{name}": (value, unit) for source, name, value, unit in now.rows()}
    assert shown["Tip1.Fz"] == (pytest.approx(-2.5), "N")
    assert shown["Pos1.Depth"] == (pytest.approx(1.25), "mm")
    assert not {"Tip1.Cnt", "Tip1.Crc", "Set1.Grip"} & shown.keys()


def test_channels_of_a_map_are_shown_in_si(tmp_path):
    now = MappedNow(open_plan(written(tmp_path, PLAIN_DBC, MAP)))
    now.update(frame("Pos1", 272, Depth=1.25, Tz=0.001, Slip=0))
    now.update(tip(2.5))
    shown = {name: (value, unit) for _, name, value, unit in now.rows()}
    assert shown["normal_force"] == (pytest.approx(2.5), "N")
    assert shown["displacement"] == (pytest.approx(1.25e-3), "m")
