"""The object dictionaries: valid for a tool nobody here wrote, and the same bytes as the DBC."""

import shutil
import subprocess
import sys
from pathlib import Path

import canopen
import pytest
import vegrip.proto

from tools.object_dictionary import _parameters, fingertip, grasp_force, known_parameters
from tools.write_eds import text
from vegrip.canopen.network import difference_of, read_eds
from vegrip.errors import ConfigError
from vegrip.grip.parameters import GraspParameters
from vegrip.runtime.lifecycle import rows
from vegrip.transport.codec.database import database

PROTO = Path(vegrip.proto.__file__).parent
FILES = ("fingertip.eds", "grasp_force.eds")


def checked(path):
    """Return what eds-validate says, and its exit code."""
    tool = Path(sys.executable).parent / "eds-validate"
    done = subprocess.run([tool, path], capture_output=True, text=True, check=False)
    return done.returncode, done.stderr


@pytest.mark.parametrize("name", FILES)
def test_the_file_passes_the_validator(name):
    assert checked(PROTO / name) == (0, "")


@pytest.mark.parametrize(
    ("was", "becomes"),
    [
        ("DefaultValue=0x20000210", "DefaultValue=0x20000220"),  # a mapped object of the wrong length
        ("[1008]\n", "[1009]\n"),  # an object that is in no list
        ("AccessType=rw", "AccessType=sometimes"),
    ],
)
def test_the_validator_is_not_blind(tmp_path, was, becomes):
    spoilt = (PROTO / "fingertip.eds").read_text().replace(was, becomes, 1)
    path = tmp_path / "spoilt.eds"
    path.write_text(spoilt)
    assert checked(path)[0] == 1


def without_comments(eds):
    start = eds.index("[Comments]")
    return eds[:start] + eds[eds.index("[MandatoryObjects]") :]


@pytest.mark.parametrize("name", FILES)
def test_the_file_is_what_is_written_from_the_declarations(name):
    there = (PROTO / name).read_text()
    device = fingertip() if name == "fingertip.eds" else grasp_force(known_parameters(there))
    same = without_comments(there) == without_comments(text(device))
    assert same, "run make format: parameters or the DBC have changed"


def test_a_parameter_keeps_its_index_when_others_come_and_go():
    first = {variable.entry.name: variable.index for variable in _parameters({})}
    others = {name: index for name, index in first.items() if name != "grip.drive_lag"}
    later = {variable.entry.name: variable.index for variable in _parameters(others | {"gone": 0x3100})}
    assert later.pop("grip.drive_lag") == 0x3101
    assert later == others


def test_every_plain_parameter_can_be_reached_by_sdo():
    dictionary = canopen.import_od(str(PROTO / "grasp_force.eds"), 16)
    plain = {name for name, value, _ in rows(GraspParameters()) if not isinstance(value, (tuple, dict))}
    assert {dictionary[index].name for index in dictionary if 0x3000 <= index < 0x6000} == plain


@pytest.mark.parametrize("name", FILES)
def test_every_pdo_is_a_classic_frame_of_the_dbc(name):
    node = canopen.LocalNode(32, canopen.import_od(str(PROTO / name), 32))
    node.associate_network(canopen.Network())
    for pdo in (node.tpdo, node.rpdo):
        pdo.read(from_od=True)
        for mapped in pdo.values():
            assert mapped.length == 64
            title = mapped.map[0].od.parent.name
            kind = f"FingertipState{title[6]}" if title.startswith("State") else title.rstrip(" 01234567")
            message = database().get_message_by_name(kind)
            for entry in mapped.map[1:]:
                field = entry.od.name
                if field == "content" or field.startswith("reserved"):
                    continue
                signal = message.get_signal_by_name(field)
                assert (entry.offset, entry.length) == (signal.start, signal.length)


@pytest.mark.parametrize("name", FILES)
def test_the_cob_ids_are_those_of_the_predefined_connection_set(name):
    dictionary = canopen.import_od(str(PROTO / name), 32)
    for index in dictionary:
        if 0x1400 <= index < 0x1600 or 0x1800 <= index < 0x1A00:
            assert 0x180 < dictionary[index][1].default & 0x7FF < 0x580


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (None, "cannot be read"),
        ("nonsense", "is not a valid EDS file"),
        ("[DeviceInfo]\n[1000]\nParameterName=x\n", "is not a valid EDS file"),
        ("other device", "object 1018sub2 is 0x2, not 0x1"),
        ("other mapping", "object 1A00sub2 is 0x20010210, not 0x20000210"),
        ("less", "object 1A02sub1 is missing"),
    ],
)
def test_an_eds_that_cannot_serve_is_refused_in_one_sentence(tmp_path, content, words):
    path = tmp_path / "my.eds"
    good = (PROTO / "fingertip.eds").read_text()
    if content == "other device":
        shutil.copy(PROTO / "grasp_force.eds", path)
    elif content == "other mapping":
        path.write_text(good.replace("0x20000210", "0x20010210"))
    elif content == "less":
        path.write_text(good[: good.index("[1A02sub1]")])
    elif content is not None:
        path.write_text(content)
    with pytest.raises(ConfigError, match=words) as caught:
        read_eds(str(path), 32, "fingertip.eds")
    assert "\n" not in str(caught.value)


def test_a_file_of_another_kind_is_refused(tmp_path):
    with pytest.raises(ConfigError, match=r"\.eds"):
        read_eds(str(tmp_path / "x.toml"), 32, "fingertip.eds")


def test_a_dictionary_does_not_differ_from_itself():
    dictionary = read_eds("", 32, "fingertip.eds")
    assert difference_of(dictionary, dictionary) == ""
