"""The bus process with its compiled loop and without: the same laws on the wall clock, and the way back."""

import subprocess
import sys
import time
from itertools import pairwise
from pathlib import Path

import can
import pytest

from vegrip.host import compiled_folder
from vegrip.transport.canbus import compiled_bus
from vegrip.transport.canbus.compiled_bus import LOOK_AGAIN, Search, library_name
from vegrip.transport.canbus.frame_time import frame_duration
from vegrip.transport.canbus.virtual_can import hub_process

PATIENCE = 60.0  # [s] of a machine that does much else
needs_compiler = pytest.mark.skipif(compiled_folder.compiler() is None, reason="no C compiler")


@pytest.fixture(params=[pytest.param("c", marks=needs_compiler), "python"])
def bus(request, runtime, monkeypatch):
    monkeypatch.setenv("VEGRIP_KERNEL", request.param)
    opened = []

    def open_bus(**options):
        opened.append(can.Bus(interface="vegrip", channel="test", fd=True, **options))
        return opened[-1]

    yield open_bus
    process = hub_process("test")
    maps = Path(f"/proc/{process}/maps").read_text() if process else ""
    for each in opened:
        each.shutdown()
    assert (library_name() in maps) == (request.param == "c")


def frame(number):
    size = (0, 1, 8, 12, 64)[number % 5]
    return can.Message(
        arbitration_id=0x100 + number % 7,
        is_extended_id=number % 3 == 0,
        is_fd=number % 2 == 0 or size > 8,
        bitrate_switch=number % 4 == 0,
        data=bytes([number & 255]) * size,
    )


def taken(bus, count):
    got = []
    deadline = time.monotonic() + PATIENCE
    while len(got) < count and time.monotonic() < deadline:
        delivery = bus.take(time.monotonic() + 0.1)
        if delivery is not None and not delivery.is_error:
            got.append(delivery)
    return got


def contents(deliveries):
    return [(one.end, one.busy, one.node, one.frame) for one in deliveries]


def test_all_hear_the_same_with_the_same_times_and_every_frame_takes_its_duration(bus):
    one, other = bus(), bus()
    plain, patient = bus(), bus(patience=0.01)
    for number in range(200):
        (one if number % 2 else other).send(frame(number), timeout=PATIENCE)
        if number == 80:
            late = bus(receive_own_messages=True)
        if number == 120:
            late.send(frame(0), timeout=PATIENCE)
    heard = taken(plain, 201)
    assert contents(taken(patient, 201)) == contents(heard)
    assert plain.overruns == patient.overruns == 0
    for before, after in pairwise(heard):
        duration = frame_duration(after.frame, plain.timing)
        assert after.end - duration >= before.end
        assert after.busy - before.busy == duration
    alone = contents(taken(late, 60))
    assert alone == contents(heard)[heard.index(next(d for d in heard if d.end == alone[0][0])) :][:60]
    assert [d.frame.data for d in heard if d.node == heard[0].node] == [
        bytes(frame(n).data) for n in range(200) if n % 2 == 0
    ]


def test_filters_that_change_in_the_middle_count_from_then_on(bus):
    sender, receiver = bus(), bus()
    for identifiers in ((1, 2, 3), (3,), (1, 3)):
        receiver.set_filters([{"can_id": n, "can_mask": 0x7FF, "extended": False} for n in identifiers])
        for identifier in (1, 2, 3):
            sender.send(can.Message(arbitration_id=identifier, is_extended_id=False))
        assert [d.frame.identifier for d in taken(receiver, len(identifiers))] == list(identifiers)


def test_a_node_with_faults_comes_and_goes_and_the_others_lose_nothing(bus):
    sender, receiver = bus(), bus()
    for number in range(90):
        if number == 30:
            bad = bus(faults={"misreading": 0.3})
        if number == 60:
            bad.shutdown()
        sender.send(frame(number), timeout=PATIENCE)
    assert [bytes(d.frame.data) for d in taken(receiver, 90)] == [bytes(frame(n).data) for n in range(90)]
    assert receiver.overruns == 0


def test_one_that_does_not_read_holds_up_no_other_and_gets_what_waited(bus):
    sender, idle, reader = bus(), bus(), bus()
    for number in range(400):
        sender.send(frame(number), timeout=PATIENCE)
    assert len(taken(reader, 400)) == 400
    assert len(taken(idle, 400)) == 400
    assert idle.overruns == 0


@pytest.mark.parametrize("mode", ["python", "numba"])
def test_the_bus_is_left_to_python_where_that_is_asked_for(mode, monkeypatch):
    monkeypatch.setenv("VEGRIP_KERNEL", mode)
    monkeypatch.setattr(compiled_bus.subprocess, "Popen", None)  # would fail
    assert Search().found(10**18) is None


@pytest.fixture
def empty(monkeypatch, tmp_path):
    """A folder without a compiled loop."""
    monkeypatch.setenv("VEGRIP_KERNEL", "c")
    monkeypatch.setenv("VEGRIP_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv("VEGRIP_RUNTIME_DIR", str(tmp_path / "run"))
    return tmp_path / "cache"


def test_without_a_compiler_python_goes_on_and_nothing_is_started(empty, monkeypatch):
    monkeypatch.setattr(compiled_bus, "compiler", lambda: None)
    monkeypatch.setattr(compiled_bus.subprocess, "Popen", None)  # would fail
    search = Search()
    assert [search.found(now * LOOK_AGAIN) for now in range(4)] == [None] * 4


def test_a_compiler_that_fails_is_asked_once(empty, monkeypatch):
    started, ended = [], subprocess.Popen

    def fail(*_, **__):
        started.append(ended([sys.executable, "-c", "raise SystemExit(1)"]))
        started[-1].wait()
        return started[-1]

    monkeypatch.setattr(compiled_bus, "compiler", lambda: "cc")
    monkeypatch.setattr(compiled_bus.subprocess, "Popen", fail)
    search = Search()
    assert [search.found(now * LOOK_AGAIN) for now in range(5)] == [None] * 5
    assert len(started) == 1


@needs_compiler
def test_the_loop_is_compiled_once_beside_the_bus_and_found_by_the_next_look(empty, monkeypatch):
    search = Search()
    assert search.found(0) is None
    assert search._compiling.wait(PATIENCE) == 0
    assert search.found(LOOK_AGAIN - 1) is None, "it looks once a second"
    assert search.found(LOOK_AGAIN) is not None
    assert [path.name for path in empty.glob("*.so")] == [f"{library_name()}.so"]
    monkeypatch.setattr(compiled_bus.subprocess, "Popen", None)  # would fail
    assert Search().found(0) is not None


@pytest.mark.long
@needs_compiler
def test_a_first_bus_carries_frames_while_its_loop_is_compiled_and_then_runs_it(
    runtime, monkeypatch, tmp_path
):
    monkeypatch.setenv("VEGRIP_KERNEL", "c")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("VEGRIP_CACHE", "cache")  # from here, wherever the bus process goes
    with (
        can.Bus(interface="vegrip", channel="first", fd=True) as sender,
        can.Bus(interface="vegrip", channel="first", fd=True) as receiver,
    ):
        maps = Path(f"/proc/{hub_process('first')}/maps")
        deadline = time.monotonic() + PATIENCE
        number = 0
        while library_name() not in maps.read_text() and time.monotonic() < deadline:
            sender.send(frame(number), timeout=PATIENCE)
            assert len(taken(receiver, 1)) == 1
            number += 1
        assert str(tmp_path / "cache" / library_name()) in maps.read_text()
        sender.send(frame(number))
        assert len(taken(receiver, 1)) == 1
        assert receiver.overruns == 0


@needs_compiler
def test_a_library_that_another_could_have_put_there_is_not_loaded(empty):
    empty.mkdir()
    (empty / f"{library_name()}.so").symlink_to("/nowhere")
    assert compiled_folder.found_library(library_name()) is None
    (empty / f"{library_name()}.so").unlink()
    (empty / f"{library_name()}.so").write_bytes(b"")
    empty.chmod(0o777)
    assert compiled_folder.found_library(library_name()) is None


def test_a_file_that_is_no_library_leaves_the_bus_to_python(empty):
    empty.mkdir(mode=0o700)
    (empty / f"{library_name()}.so").write_bytes(b"no library")
    assert Search().found(0) is None


def test_the_bus_process_loads_little():
    """It is started for every virtual bus; numpy, python-can and cantools cost three times what it needs."""
    code = "import sys, vegrip.transport.canbus.hub; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not {"numba", "numpy", "can", "cantools", "vegrip.c99", "vegrip.model"} & set(done.stdout.split())
