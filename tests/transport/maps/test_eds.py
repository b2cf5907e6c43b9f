"""The EDS of a CANopen hand as a database: the frames of its PDOs, our own EDS as an example."""

import math
import re
from pathlib import Path

import pytest

from vegrip.errors import ConfigError
from vegrip.transport.codec import Frame
from vegrip.transport.mapped.canopen_nodes import read_eds
from vegrip.transport.mapped.codec import MappedCodec
from vegrip.transport.mapped.plan import open_plan

EDS = Path(__file__).parents[3] / "proto" / "fingertip.eds"
MAP = """
database = "their.eds"
nodes = { thumb = 32, index = 33 }
[fingers.thumb]
trigger = "thumb_TPDO1"
[fingers.thumb.normal_force]
signal = "thumb_TPDO1.State_1_normal_force"
unit = "mN"
invalid = [-32768]
[fingers.thumb.displacement]
signal = "thumb_TPDO2.State_2_displacement"
unit = "um"
[fingers.index.normal_force]
signal = "index_TPDO1.State_1_normal_force"
unit = "mN"
[fingers.thumb.command]
signal = "thumb_RPDO1.ForceCommand_normal_force"
unit = "mN"
set = { ForceCommand_expires = 50 }
"""


def plan_of(folder, text=MAP, eds=None):
    (folder / "their.eds").write_text(EDS.read_text() if eds is None else eds)
    (folder / "hand.toml").write_text(text)
    return open_plan(folder / "hand.toml")


def test_pdos_of_each_node_are_read_by_the_names_of_their_objects(tmp_path):
    codec = MappedCodec(plan_of(tmp_path))
    codec.decode_all(Frame(0x280 + 32, bytes([0, 0, 0, 0, 0xE8, 0x03, 0, 0]), False, 1))
    (thumb,) = codec.decode_all(Frame(0x180 + 32, bytes([0, 0, 0xDC, 0x05, 0, 0, 0, 0]), False, 2))
    assert (thumb.finger, thumb.normal_force) == ("thumb", pytest.approx(1.5))
    assert thumb.displacement == pytest.approx(1e-3)
    (index,) = codec.decode_all(Frame(0x180 + 33, bytes([0, 0, 0x64, 0, 0, 0, 0, 0]), False, 3))
    assert (index.finger, index.normal_force) == ("index", pytest.approx(0.1))
    (none,) = codec.decode_all(Frame(0x180 + 32, bytes([0, 0, 0, 0x80, 0, 0, 0, 0]), False, 4))
    assert math.isnan(none.normal_force)


def test_the_nodes_are_started_before_anything_comes(tmp_path):
    assert [frame[:2] for frame in MappedCodec(plan_of(tmp_path)).opening] == [
        (0, bytes([1, 32])),
        (0, bytes([1, 33])),
    ]


@pytest.mark.parametrize(
    ("text", "eds", "said"),
    [
        (
            MAP.replace("nodes = { thumb = 32, index = 33 }", ""),
            None,
            "the map does not say which node is which finger",
        ),
        (MAP.replace("index = 33", "index = 200"), None, "must lie in 1 .. 127"),
        (MAP, "hello", "cannot be read as an EDS"),
        (MAP, "[DeviceInfo]\n", "maps no object into a PDO"),
        (MAP.replace("State_1_normal_force", "State_1_force"), None, "has no signal 'State_1_force'"),
    ],
)
def test_an_eds_that_cannot_serve_is_refused_in_a_sentence(tmp_path, text, eds, said):
    with pytest.raises(ConfigError, match=said):
        plan_of(tmp_path, text, eds)


@pytest.mark.parametrize("node", [1, 32, 127])
def test_a_pdo_without_an_identifier_of_its_own_has_that_of_the_predefined_connections(tmp_path, node):
    """CiA 301: TPDO 1 .. 4 from 180h on in steps of 100h, RPDO 1 .. 4 from 200h on, and the node-ID."""
    text = re.sub(r"(?ms)^\[1[48]00sub1\].*?(?=^\[)", "", EDS.read_text())
    places = {"RPDO": (0x1400, 0x1600), "TPDO": (0x1800, 0x1A00)}
    for first in (one for pair in places.values() for one in pair):
        sections = re.findall(rf"(?ms)^\[{first:04X}(?:sub\w)?\].*?(?=^\[|\Z)", text)
        for number in range(1, 5):
            text = re.sub(rf"(?ms)^\[{first + number:04X}(?:sub\w)?\].*?(?=^\[|\Z)", "", text)
            text += "".join(one.replace(f"[{first:04X}", f"[{first + number:04X}") for one in sections)
    (tmp_path / "their.eds").write_text(text)
    found = read_eds(tmp_path / "their.eds", {"thumb": node}).messages
    usual = {
        f"thumb_{kind}{number + 1}": first + 0x100 * number + node
        for kind, first in (("TPDO", 0x180), ("RPDO", 0x200))
        for number in range(4)
    }
    assert {name: one.identifier for name, one in found.items() if "PDO" in name} == usual


def test_a_pdo_with_an_identifier_of_its_own_has_that(tmp_path):
    own = {f"{kind}{n + 1}": base + n for kind, base in (("RPDO", 0x311), ("TPDO", 0x322)) for n in range(3)}
    text = EDS.read_text()
    for name, identifier in own.items():
        section = f"{0x13FF + int(name[-1]) + 0x400 * (name[0] == 'T'):X}sub1"
        text = re.sub(rf"(?s)(\[{section}\].*?DefaultValue=)\S+", rf"\g<1>{identifier}", text, count=1)
    (tmp_path / "their.eds").write_text(text)
    found = read_eds(tmp_path / "their.eds", {"a": 32}).messages
    assert {name: one.identifier for name, one in found.items() if "PDO" in name} == {
        f"a_{name}": identifier for name, identifier in own.items()
    }
    assert not any(one.fd for one in found.values())


@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_a_pdo_has_as_many_objects_as_sub_index_0_says_whatever_stands_behind(tmp_path, count):
    head, section, rest = EDS.read_text().partition("[1A00sub0]")
    (tmp_path / "their.eds").write_text(
        head + section + rest.replace("DefaultValue=0x4\n", f"DefaultValue={count}\n", 1)
    )
    found = read_eds(tmp_path / "their.eds", {"thumb": 32}).messages["thumb_TPDO1"]
    every = re.findall(r"(?ms)^\[1A00sub[1-4]\].*?^DefaultValue=0x\w{6}(\w\w)$", rest)
    bits = [int(one, 16) for one in every[:count]]
    assert [signal.length for signal in found.signals.values()] == bits
    assert found.length == math.ceil(sum(bits) / 8)
    assert len(every) == 4


def changed(folder, *pairs):
    text = EDS.read_text()
    for before, after in pairs:
        assert before in text
        text = text.replace(before, after, 1)
    (folder / "their.eds").write_text(text)
    return read_eds(folder / "their.eds", {"thumb": 32}).messages


FIRST = "0x20000110"  # the first object of TPDO1, of 16 bits


def test_a_dummy_fills_and_a_mapping_ends_at_the_first_object_that_is_missing(tmp_path):
    found = changed(tmp_path, (FIRST, "0x00050008"), ("[1A00sub3]", "[1A00sub9]"))["thumb_TPDO1"]
    assert [signal.start for signal in found.signals.values()] == [8]


@pytest.mark.parametrize(
    ("mapped", "said"),
    [("0x00200010", "0020:00 is mapped into a PDO and not described"), ("0x20000120", "TPDO1 maps 80 bits")],
)
def test_a_pdo_that_cannot_be_is_refused(tmp_path, mapped, said):
    with pytest.raises(ConfigError, match=said):
        changed(tmp_path, (FIRST, mapped))


@pytest.mark.parametrize(("factor", "scale"), [("0.5", 0.5), ("0", 1.0)])
def test_an_object_has_the_factor_and_the_unit_that_stand_beside_it(tmp_path, factor, scale):
    message = changed(tmp_path, ("[2000sub2]\n", f"[2000sub2]\nFactor={factor}\nUnit=mN\n"))["thumb_TPDO1"]
    signal = message.signals["State_1_normal_force"]
    assert (signal.scale, signal.unit) == (scale, "mN")


def test_a_pdo_of_which_no_identifier_is_stated_has_the_usual_one(tmp_path):
    assert changed(tmp_path, ("DefaultValue=$NODEID+0x40000180\n", ""))["thumb_TPDO1"].identifier == 0x1A0


def test_a_pdo_that_is_switched_off_or_empty_is_named_by_its_identifier(tmp_path):
    """Of each node, whatever else stands in the COB-ID; what else it sends is read."""
    text = EDS.read_text().replace("$NODEID+0x40000180", "$NODEID+0xC0000180")
    head, section, rest = text.partition("[1A01sub0]")
    (tmp_path / "their.eds").write_text(
        head + section + rest.replace("DefaultValue=0x5\n", "DefaultValue=0\n", 1)
    )
    found = read_eds(tmp_path / "their.eds", {"thumb": 32, "index": 33})
    why = {
        identifier: sentence.partition(" in this EDS")[0] for identifier, sentence in found.left_out.items()
    }
    assert why == {
        0x1A0: "thumb_TPDO1 is switched off (bit 31 of its COB-ID)",
        0x1A1: "index_TPDO1 is switched off (bit 31 of its COB-ID)",
        0x2A0: "thumb_TPDO2 maps no object (sub-index 0 of 1A01 is 0)",
        0x2A1: "index_TPDO2 maps no object (sub-index 0 of 1A01 is 0)",
    }
    sent = {name: message.identifier for name, message in found.messages.items() if "_TPDO" in name}
    assert sent == {"thumb_TPDO3": 0x3A0, "index_TPDO3": 0x3A1}


@pytest.mark.parametrize(("node", "is_taken"), [(0, False), (1, True), (127, True), (128, False)])
def test_a_node_has_an_identifier_of_1_to_127(tmp_path, node, is_taken):
    (tmp_path / "their.eds").write_text(EDS.read_text())
    if is_taken:
        found = read_eds(tmp_path / "their.eds", {"thumb": node})
        assert found.opening == ((0, bytes((1, node))),)
        assert found.messages["thumb_TPDO1"].identifier == 0x180 + node
    else:
        with pytest.raises(ConfigError, match=rf"node-ID of thumb is {node}; it must lie in 1 \.\. 127"):
            read_eds(tmp_path / "their.eds", {"thumb": node})


def filled(folder, bits):
    """Return TPDO1 with a dummy in front, so that it has ``bits`` in all; it has 64 as it stands."""
    found = changed(folder, (FIRST, f"0x000500{bits - 48:02X}"))
    return found["thumb_TPDO1"]


def test_a_pdo_may_have_all_64_bits_of_a_frame_and_none_more(tmp_path):
    assert filled(tmp_path, 64).length == 8
    with pytest.raises(ConfigError, match="TPDO1 maps 65 bits; a frame has 64"):
        filled(tmp_path, 65)


@pytest.mark.parametrize("number", [5, 511, 512])
def test_a_pdo_is_read_up_to_the_last_there_is(tmp_path, number):
    """CiA 301 has 512 of each kind; those behind the fourth have no usual identifier."""
    own = [(f"[{first:04X}", f"[{first + number - 1:04X}") for first in (0x1800, 0x1A00)]
    text = EDS.read_text().replace("$NODEID+0x40000180", "0x123")
    for before, after in own:
        assert before in text
        text = text.replace(before, after)
    (tmp_path / "their.eds").write_text(text)
    found = read_eds(tmp_path / "their.eds", {"thumb": 32}).messages
    assert "thumb_TPDO1" not in found
    assert found[f"thumb_TPDO{number}"].identifier == 0x123


def test_objects_of_equal_names_stay_apart_in_a_pdo(tmp_path):
    """What no name can hold becomes an underscore, so that other names may become equal."""
    text = EDS.read_text()
    for section, name in (("2000sub1", "Force 1"), ("2000sub2", "Force-1")):
        text, count = re.subn(rf"(?s)(\[{section}\].*?ParameterName=)[^\n]*", rf"\g<1>{name}", text, count=1)
        assert count == 1
    (tmp_path / "their.eds").write_text(text)
    found = read_eds(tmp_path / "their.eds", {"thumb": 32}).messages
    plain = read_eds(EDS, {"thumb": 32}).messages
    for message in ("thumb_TPDO1", "thumb_SDO"):
        kept = [(one.start, one.length, one.selectors) for one in found[message].signals.values()]
        assert kept == [(one.start, one.length, one.selectors) for one in plain[message].signals.values()]
    assert list(found["thumb_TPDO1"].signals)[:2] == ["State_1_Force_1", "State_1_Force_1_1"]


@pytest.mark.parametrize(
    ("access", "is_read", "is_written"),
    [("wo", False, True), ("ro", True, False), ("const", True, False), ("rw", True, True)],
)
def test_an_object_is_read_and_written_as_its_access_allows(tmp_path, access, is_read, is_written):
    text, count = re.subn(r"(?s)(\[2000sub2\].*?AccessType=)\w+", rf"\g<1>{access}", EDS.read_text(), count=1)
    assert count == 1
    (tmp_path / "their.eds").write_text(text)
    found = read_eds(tmp_path / "their.eds", {"thumb": 32}).messages
    assert ("State_1_normal_force" in found["thumb_SDO"].signals) == is_read
    assert ("State_1_normal_force" in found["thumb_SDO_WRITE"].signals) == is_written
