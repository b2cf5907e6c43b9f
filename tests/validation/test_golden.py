"""The golden answers are what today's code answers, and a change of any answer is seen."""

import itertools
import math
import os
import subprocess
import sys
from pathlib import Path

import pytest

from validation.golden import events, store
from validation.golden.cases import ALL_WIRES, cases, faults, fits, is_small
from validation.golden.falsify import falsified
from validation.golden.settings import SETTINGS
from validation.golden.store import Answered

ROOT = Path(__file__).parents[2]
LINES = {"commands": ["1 thumb 2.5", "2 thumb 2.6"], "counts": ["lost 3"]}
NUMBERS = {"commands": 2, "force": [2.5, 2.6], "friction": math.nan}


def answered(lines=None, **numbers):
    return Answered("a case", {**LINES, **(lines or {})}, {**NUMBERS, **numbers})


@pytest.mark.long
def test_todays_code_gives_the_golden_answers():
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, "-m", "validation.golden", "--quick", "-j", "1"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, env=environment)
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]


def test_every_pair_of_wire_setting_and_disturbance_is_met():
    met = list(cases())
    usable = {(wire, name) for name, one in SETTINGS.items() for wire in ALL_WIRES if fits(wire, one)}
    great = [fault for fault in faults() if not is_small(fault)]
    assert {(case.wire, case.setting) for case in met if case.what == "undisturbed"} == usable
    assert {(case.wire, case.setting) for case in met if case.what.startswith("seed ")} == usable
    assert {(case.setting, case.what) for case in met} >= set(itertools.product(SETTINGS, great))
    assert {(case.wire, case.what) for case in met} >= set(itertools.product(ALL_WIRES, great))
    assert len({case.name for case in met}) == len(met)


def test_every_case_has_an_entry_in_the_file():
    assert {case.name for case in cases() if case.is_quick} <= store.read().keys()


def test_a_recording_is_read_as_it_was_written(tmp_path, monkeypatch):
    path, tape = tmp_path / "inputs.npz", events.load("pinch")
    events.save({"pinch": tape}, path)
    monkeypatch.setattr(events, "PATH", path)
    read = events.load.__wrapped__("pinch")
    assert [repr(event) for event in read.events] == [repr(event) for event in tape.events]
    assert read.fingers == tape.fingers


def test_what_is_false_is_the_same_for_the_same_seed_only():
    tape = events.load("hand").until(0.4)
    assert repr(falsified(tape, 3)) == repr(falsified(tape, 3)) != repr(falsified(tape, 4))


def test_equal_answers_differ_in_nothing():
    assert store.differences(answered(), answered().entry, None) == []


def test_a_difference_says_which_kind_and_the_first_line(tmp_path, monkeypatch):
    monkeypatch.setattr(store, "TRACES", tmp_path)
    store.keep(answered())
    changed = answered({"commands": ["1 thumb 2.5", "2 thumb 2.7"]}, force=[2.5, 2.7])
    assert store.differences(changed, answered().entry, None) == [
        "commands: 1 of 2 lines differ, first number 1: '2 thumb 2.6' was, '2 thumb 2.7' is",
        "numbers: force was [2.5, 2.6], is [2.5, 2.7]",
    ]


def test_answers_of_a_librarys_solver_may_differ_in_what_the_processor_decides_and_no_more():
    lines = {**LINES, "conditions": []}
    expected = Answered("a case", lines, NUMBERS, of_library=True).entry
    for force, is_said in (([2.5, 2.60001], False), ([2.5, 2.6001], True)):
        now = Answered(
            "a case", {**lines, "commands": ["1 thumb 9"]}, {**NUMBERS, "force": force}, of_library=True
        )
        assert bool(store.differences(now, expected, None)) == is_said
    lost = Answered("a case", {**lines, "counts": ["lost 4"]}, NUMBERS, of_library=True)
    assert store.differences(lost, expected, None)


def test_a_difference_without_a_trace_on_this_machine_names_the_digests(tmp_path, monkeypatch):
    monkeypatch.setattr(store, "TRACES", tmp_path)
    (said,) = store.differences(answered({"counts": ["lost 4"]}), answered().entry, None)
    assert said.startswith("counts: ")
    assert said.endswith("came (no trace of it here)")


@pytest.mark.parametrize(
    ("force", "is_near"), [([2.5, 2.6000001], True), ([2.5, 2.7], False), ([2.5], False)]
)
def test_within_a_tolerance_numbers_count_and_not_digests(force, is_near):
    changed = answered({"commands": ["other"]}, force=force)
    assert (store.differences(changed, answered().entry, 1e-6) == []) == is_near


def test_a_case_that_is_new_is_no_silent_success():
    assert store.differences(answered(), None, None) == ["it is not in the file; --update adds it"]
