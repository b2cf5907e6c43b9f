"""A finger in single precision judges as in double, and commands nearly the same."""

import shutil
import subprocess
from pathlib import Path

import pytest

from validation.compiled_finger import Event, Log, Replay, hostile, record
from validation.faults.table import CASES, Case
from validation.finger_in_floats import parted
from vegrip.c99 import host
from vegrip.export import Exported, Request, write_export
from vegrip.export.measure import STRICT
from vegrip.messages import Condition, FingertipState
from vegrip.model import paper_model
from vegrip.transport.codec import CanCodec

pytestmark = pytest.mark.skipif(host.compiler() is None, reason="no C compiler")
RAMP_STEP = 0.25  # [N] that the fail-safe ramp climbs from one renewed command to the next
NS = 1_000_000_000


def run(*command: str | Path, where: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(list(map(str, command)), cwd=where, capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Exported]:
    folder = tmp_path_factory.mktemp("firmware")
    request = Request(paper_model(8e-3), prefix="lh", frames=260, entry="finger", precision="float")
    return folder, write_export(request, folder)


def test_the_self_test_passes_within_its_bounds(exported: tuple[Path, Exported]) -> None:
    test = exported[1].measured.host_run
    assert test is not None
    assert test.passed
    assert test.equal < test.numbers
    assert 1e-6 < test.largest < 2.0 * RAMP_STEP


def test_a_finger_takes_little_more_than_half(exported: tuple[Path, Exported]) -> None:
    assert exported[1].ram < 5000


def test_it_runs_on_an_emulated_cortex_m4f(exported: tuple[Path, Exported]) -> None:
    if shutil.which("arm-none-eabi-gcc") is None or shutil.which("qemu-system-arm") is None:
        pytest.skip("no arm-none-eabi-gcc or no qemu-system-arm")
    there = exported[1].measured.cortex_run
    assert there is not None
    assert there.machine == "Cortex-M4F in qemu"
    assert there.passed


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_nothing_is_widened_to_double(compiler: str, exported: tuple[Path, Exported], tmp_path: Path) -> None:
    if shutil.which(compiler) is None:
        pytest.skip(f"no {compiler}")
    strict = (*STRICT, "-Wdouble-promotion")
    source = "lh_finger.c"
    done = run(
        compiler, *host.EXACT, "-O2", *strict, "-I.", "-c", source, "-o", tmp_path / "o", where=exported[0]
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.long
def test_the_hand_is_judged_as_in_double_and_forces_agree_within_two_millinewton() -> None:
    found = parted(record(None, 2.0, "hand"))
    assert found.commands > 1900
    assert found.judged_otherwise == 0
    assert 0.0 < found.largest < 2e-3


def test_hostile_states_are_judged_as_in_double() -> None:
    found = parted(hostile(record(None, 2.0, "hand"), 3))
    assert found.commands > 1000
    assert found.judged_otherwise == 0
    assert found.largest < 2.0 * RAMP_STEP


@pytest.mark.parametrize("case", [case for case in CASES if not case.slow][::9], ids=lambda case: case.name)
def test_a_fault_of_the_table_is_seen_at_the_same_frame_as_in_double(case: Case) -> None:
    found = parted(record(case, 0.0))
    assert found.judged_otherwise == 0
    assert found.largest < 2.0 * RAMP_STEP


def slow_clock(seconds: int) -> Log:
    """A sender whose clock is half an hour behind and loses 150 us a second, less than is allowed."""
    log = Log(("thumb",), sender_time=True)
    sender = CanCodec(log.fingers, fd=True)
    for i in range(10 * seconds):
        now = 40 * 60 * NS + i * NS // 10
        own = now - 30 * 60 * NS - i * 15_000
        force, depth = 1.0 + 0.01 * (i % 7), 1e-4 + 1e-6 * (i % 5)
        state = FingertipState(own, "thumb", i, normal_force=force, displacement=depth)
        log.events += [Event(now, frame._replace(stamp=now)) for frame in sender.encode(state)]
    return log


def test_a_clock_that_is_far_off_and_runs_slow_is_followed_for_ever() -> None:
    seconds = 360  # a float cannot follow it, and is 50 ms late after 333 s, which is the time-out
    conditions = Replay(slow_clock(seconds), "c-float").run().conditions
    assert len(conditions) == 10 * seconds
    assert set(conditions[5:]) == {(Condition.OK,)}  # five good states end what there was before the first
