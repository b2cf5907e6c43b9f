"""Every check says what it found, and how to mend it when it is not well."""

import json
import shutil
from collections import namedtuple
from pathlib import Path

import pytest

from vegrip.cli import main
from vegrip.grip.settings import ControlSettings
from vegrip.host.realtime import Permission
from vegrip.runtime import doctor
from vegrip.runtime.doctor import Grade, examine, fail, ok, warn, worst


def written(root, path, text):
    file = root / path
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text + "\n")


def test_the_worst_counts():
    assert worst([]) is Grade.OK
    assert worst([ok("a", "b"), fail("a", "b", "c"), warn("a", "b", "c")]) is Grade.FAIL


SOURCE = "sys/devices/system/clocksource/clocksource0/current_clocksource"


@pytest.mark.parametrize(("source", "grade"), [("tsc", Grade.OK), ("hpet", Grade.WARN), ("", Grade.WARN)])
def test_a_slow_clock_source_is_told(tmp_path, source, grade):
    if source:
        written(tmp_path, SOURCE, source)
    assert doctor.clock_source(tmp_path).grade is grade


def test_a_coarse_clock_is_told_by_its_step():
    ticks = iter(range(0, 10**9, 1000))
    coarse = doctor.clock(lambda: next(ticks) // 40_000 * 40_000)
    assert coarse.grade is Grade.WARN
    assert "40.0 us" in coarse.text
    fine = iter(range(0, 10**9, 60))
    assert doctor.clock(lambda: next(fine)).grade is Grade.OK


def test_late_sleeps_are_told(monkeypatch):
    now = [0.0]
    monkeypatch.setattr(doctor.time, "monotonic", lambda: now[0])

    def sleeper(late):
        def sleep(seconds):
            now[0] += seconds + late

        return sleep

    assert doctor.wake_up(sleeper(1e-4)).grade is Grade.OK
    late = doctor.wake_up(sleeper(3e-3))
    assert late.grade is Grade.WARN
    assert "3000 us" in late.text


@pytest.mark.parametrize(
    ("governors", "grade"), [(["performance"] * 2, Grade.OK), (["performance", "powersave"], Grade.WARN)]
)
def test_one_processor_that_saves_power_is_enough_to_be_told(tmp_path, governors, grade):
    for i, governor in enumerate(governors):
        written(tmp_path, f"sys/devices/system/cpu/cpu{i}/cpufreq/scaling_governor", governor)
    found = doctor.governor(tmp_path)
    assert found.grade is grade
    assert grade is Grade.OK or "cpupower" in found.remedy


@pytest.mark.parametrize(("free", "grade"), [(5e9, Grade.OK), (5e8, Grade.WARN), (1e6, Grade.FAIL)])
def test_room_for_recordings(tmp_path, monkeypatch, free, grade):
    usage = namedtuple("usage", "total used free")
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage(0, 0, free))
    assert doctor.disk(tmp_path).grade is grade


@pytest.mark.parametrize(
    ("allowed", "grade"),
    [
        (Permission(99, may_lock=True), Grade.OK),
        (Permission(99, may_lock=False), Grade.WARN),
        (Permission(0, may_lock=True), Grade.WARN),
    ],
)
def test_priority_that_is_not_allowed_is_told_with_the_line_that_allows_it(monkeypatch, allowed, grade):
    monkeypatch.delenv("VEGRIP_REALTIME", raising=False)
    found = doctor.priority(allowed)
    assert found.grade is grade
    assert grade is Grade.OK or ("rtprio" in found.remedy and "memlock" in found.remedy)


def test_priority_that_is_switched_off_is_told(monkeypatch):
    monkeypatch.setenv("VEGRIP_REALTIME", "0")
    assert "switched off" in doctor.priority(Permission(99, may_lock=True)).text


def test_a_cache_that_cannot_be_written_fails(tmp_path):
    (tmp_path / "file").write_text("")
    assert doctor.compiler_cache(tmp_path / "file" / "cache").grade is Grade.FAIL
    assert doctor.compiler_cache(tmp_path / "cache").grade is Grade.WARN, "empty"
    (tmp_path / "cache" / "a.nbc").write_text("")
    assert doctor.compiler_cache(tmp_path / "cache").grade is Grade.OK


def test_a_socket_folder_open_to_others_fails(tmp_path, monkeypatch):
    tmp_path.chmod(0o777)
    monkeypatch.setenv("VEGRIP_RUNTIME_DIR", str(tmp_path))
    found = doctor.sockets()
    assert found.grade is Grade.FAIL
    assert "VEGRIP_RUNTIME_DIR" in found.remedy


def link(name, kind, flags=("UP",), mtu=72, **data):
    info = {"info_kind": kind, "info_data": data}
    return {"ifname": name, "link_type": "can", "flags": list(flags), "mtu": mtu, "linkinfo": info}


BITS = {"bittiming": {"bitrate": 1_000_000}, "data_bittiming": {"bitrate": 5_000_000}}


@pytest.mark.parametrize(
    ("interface", "grade", "says"),
    [
        (
            link("can0", "can", restart_ms=100, state="ERROR-ACTIVE", **BITS),
            Grade.OK,
            "1000000 bit/s and 5000000",
        ),
        (link("can0", "can", flags=()), Grade.FAIL, "no bit rate"),
        (link("can0", "can", flags=(), **BITS), Grade.WARN, "down"),
        (link("can0", "can", state="BUS-OFF", **BITS), Grade.FAIL, "BUS-OFF"),
        (link("can0", "can", **BITS), Grade.WARN, "stays off"),
        (link("vcan0", "vcan"), Grade.OK, "vcan, up"),
        (link("vcan0", "vcan", mtu=16), Grade.OK, "classic"),
    ],
)
def test_each_interface_is_judged(interface, grade, says):
    (found,) = doctor.interfaces(lambda: json.dumps([{"ifname": "lo"}, interface]))
    assert found.grade is grade
    assert says in found.text
    assert (found.grade is Grade.OK) == (not found.remedy)


def test_no_interface_is_no_fault_and_no_program_to_ask_is_told():
    (none,) = doctor.interfaces(lambda: "[]")
    assert none.grade is Grade.OK
    (missing,) = doctor.interfaces(lambda: None)
    assert "iproute2" in missing.remedy
    (garbled,) = doctor.interfaces(lambda: "2: lo: <LOOPBACK>")
    assert garbled.grade is Grade.WARN


def test_the_whole_examination_has_a_line_for_everything_and_a_remedy_for_each_complaint():
    findings = examine()
    names = {finding.check for finding in findings}
    assert names >= {
        "kernel",
        "clock",
        "wake-up",
        "processor",
        "priority",
        "sockets",
        "compiler cache",
        "disk",
    }
    assert all(finding.remedy for finding in findings if finding.grade is not Grade.OK)


def test_json_and_exit_code_agree(capsys):
    code = main(["doctor", "--json"])
    told = json.loads(capsys.readouterr().out)
    assert code == (4 if told["grade"] == "fail" else 0)
    assert {finding["grade"] for finding in told["findings"]} <= {"ok", "warn", "fail"}


PLAIN = """[[node]]
program = "grasp_force"
"""


@pytest.mark.parametrize(
    ("text", "grade", "said"),
    [
        (PLAIN, Grade.WARN, f"so it is {ControlSettings().limits.max_force:g} N"),
        (PLAIN + "parameters.limits.max_force = 8.0\n", Grade.OK, "limits.max_force is 8.0 N"),
        (PLAIN + 'transport = { kind = "can", map = "hand.toml" }\n', Grade.OK, "is 12.0 N, by "),
        (
            PLAIN + 'transport = { kind = "can", map = "hand.toml" }\nparameters.limits.max_force = 8.0\n',
            Grade.OK,
            "limits.max_force is 8.0 N",
        ),
    ],
)
def test_what_bounds_a_grip_is_told_of_a_launch_file(tmp_path, text, grade, said):
    (tmp_path / "own.dbc").write_text(
        'VERSION ""\nBU_: X\nBO_ 5 Tip: 8 X\n SG_ Fz : 0|16@1- (0.01,0) [-12|12] "N" X\n'
        'BO_ 6 Set: 8 X\n SG_ F : 0|16@1+ (0.01,0) [0|20] "N" X\n'
    )
    (tmp_path / "hand.toml").write_text(
        'database = "own.dbc"\n[fingers.thumb]\nnormal_force = { signal = "Tip.Fz" }\n'
        'command = { signal = "Set.F" }\n'
    )
    (tmp_path / "launch.toml").write_text(text)
    (found,) = doctor.largest_forces(tmp_path / "launch.toml")
    assert found.grade is grade
    assert said in found.text
    assert bool(found.remedy) is (grade is Grade.WARN)


def test_every_launch_file_of_ours_states_the_largest_force():
    paths = sorted((Path(__file__).parents[2] / "launch").glob("*.toml"))
    found = [each for path in paths for each in doctor.largest_forces(path)]
    assert len(found) >= len(paths) == 5
    assert {each.grade for each in found} == {Grade.OK}


def test_a_launch_file_is_examined_beside_the_machine(capsys):
    assert main(["doctor", "demo", "--json"]) in (0, 4)
    told = json.loads(capsys.readouterr().out)["findings"]
    assert told[-1]["text"] == "limits.max_force is 15.0 N"
    assert main(["doctor", "no-such-file"]) == 3
    assert "there is no launch file 'no-such-file'" in capsys.readouterr().err
