"""Whatever is exported builds anywhere, has nothing that firmware has not, and passes its own test."""

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.export.firmware import Firmware, run, sources
from vegrip.c99 import host
from vegrip.export.measure import STRICT

pytestmark = pytest.mark.skipif(host.compiler() is None, reason="no C compiler")
Make = Callable[..., Firmware]
NUMBERS_PER_FRAME = {"estimator": 20, "finger": 3}  # at least
BOUND_IN_FLOATS = {"estimator": 0.2, "finger": 0.5}
"""A fifth of an estimate's error; of a command [N], two steps in which the fail-safe ramp climbs."""
WRONG = {
    "estimator": (r"(#define LH_K_WIDE )1\.73\S*", r"\g<1>1.7321"),
    "finger": (r"(#define LH_K_REASON_RAISE )1\b", r"\g<1>2"),
}
LONGEST = {"estimator": "update", "finger": "frame"}
in_floats = pytest.mark.long  # an export of its own, and what it does on a Cortex
both_precisions = pytest.mark.parametrize("precision", ["double", pytest.param("float", marks=in_floats)])


@pytest.fixture(params=["estimator", "finger"])
def entry(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.mark.long
@both_precisions
def test_the_self_test_passes_to_the_bit_and_in_floats_within_its_bound(
    entry: str, precision: str, firmware: Make
) -> None:
    test = firmware(entry, precision)[1].measured.host_run
    assert test is not None
    assert test.passed
    if precision == "double":
        assert test.numbers > NUMBERS_PER_FRAME[entry] * test.frames
        assert (test.equal, test.largest) == (test.numbers, 0.0)
    else:
        assert test.equal < test.numbers
        assert 1e-6 < test.largest < BOUND_IN_FLOATS[entry]


@pytest.mark.long
def test_a_wrong_number_fails_the_self_test(entry: str, firmware: Make, tmp_path: Path) -> None:
    folder, (library, *others) = firmware(entry)[0], sources(entry)
    text = (folder / library).read_text()
    wrong = re.sub(*WRONG[entry], text)
    assert wrong != text
    (tmp_path / library).write_text(wrong)
    given = (*host.EXACT, f"-I{folder}", tmp_path / library, *others, "-o", tmp_path / "t", "-lm")
    built = run(str(host.compiler()), *given, where=folder)
    assert built.returncode == 0, built.stderr
    done = run(tmp_path / "t", where=folder)
    assert done.returncode == 1
    assert "FAIL" in done.stdout


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
@both_precisions
def test_no_compiler_warns_and_nothing_is_widened_to_double(
    entry: str, precision: str, compiler: str, firmware: Make, tmp_path: Path
) -> None:
    if shutil.which(compiler) is None:
        pytest.skip(f"no {compiler}")
    (folder, exported), (library, *others) = firmware(entry, precision), sources(entry)
    assert exported.measured.host is not None  # gcc sees some of it only as it optimises, as there
    for source in (library, *others, "examples/linux.c", "examples/bare_metal.c"):
        widened = precision == "float" and source == library
        thorough = ("-O2", "-Wdouble-promotion") if widened and compiler == "gcc" else ("-fsyntax-only",)
        given = (*host.EXACT, *thorough, *STRICT, "-I.", "-c", source, "-o", tmp_path / "o")
        done = run(compiler, *given, where=folder)
        assert (done.returncode, done.stderr) == (0, ""), source


@pytest.mark.long
def test_no_undefined_behaviour(entry: str, sanitized: Callable[..., None]) -> None:
    sanitized(entry, *sources(entry)[1:])


def test_cppcheck_finds_nothing(entry: str, firmware: Make) -> None:
    if shutil.which("cppcheck") is None:
        pytest.skip("no cppcheck")
    # its rule of ignored results takes the elements of a compound literal for statements
    rules = ("--enable=warning,performance,portability", "--suppress=ignoredReturnValue")
    given = ("-q", "--std=c99", *rules, "--error-exitcode=1", *sources(entry))
    done = run("cppcheck", *given, where=firmware(entry)[0])
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    ("precision", "machine"), [("double", "Cortex-M7"), pytest.param("float", "Cortex-M4F", marks=in_floats)]
)
def test_it_runs_on_an_emulated_cortex(entry: str, precision: str, machine: str, firmware: Make) -> None:
    if shutil.which("arm-none-eabi-gcc") is None or shutil.which("qemu-system-arm") is None:
        pytest.skip("no arm-none-eabi-gcc or no qemu-system-arm")
    measured = firmware(entry, precision)[1].measured
    assert measured.cortex is not None
    assert 10_000 < measured.cortex.flash < (40_000 if (entry, precision) == ("estimator", "float") else 1e6)
    there = measured.cortex_run
    assert there is not None
    assert there.machine == f"{machine} in qemu"
    assert there.passed
    assert precision == "float" or there.equal > 0.9 * there.numbers


def test_a_search_finds_calls_that_take_more_than_the_recorded_ones(entry: str, firmware: Make) -> None:
    """No recorded call takes more instructions than the worst found, the first after a silence twice."""
    if shutil.which("arm-none-eabi-gcc") is None or shutil.which("qemu-system-arm") is None:
        pytest.skip("no arm-none-eabi-gcc or no qemu-system-arm")
    folder, exported = firmware(entry)
    measured = exported.measured
    assert measured.search is not None
    assert measured.cortex_run is not None
    recorded = {name: most for name, (_, most) in measured.cortex_run.instructions.items()}
    assert measured.search.most.keys() == recorded.keys()
    assert all(measured.search.most[name] >= most for name, most in recorded.items())
    assert measured.search.most[LONGEST[entry]] > 2 * recorded[LONGEST[entry]]
    assert f"most of {measured.search.inputs} inputs" in (folder / "REPORT.md").read_text()


def test_nothing_that_firmware_has_not(entry: str, firmware: Make) -> None:
    text = "".join((firmware(entry)[0] / f"lh_{entry}.{kind}").read_text() for kind in "ch")
    code = re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL)
    known = {f"lh_{entry}.h", "math.h", "stddef.h", "stdbool.h", "stdint.h"}
    assert set(re.findall(r"#include\s*[<\"](\S+)[>\"]", code)) == known
    assert not re.search(r"\b(malloc|calloc|free|printf|goto|setjmp|errno)\b", code)
    if entry == "estimator":
        assert not re.findall(r"^static (?!const|inline|\w+ ?\*?\w+\()", code, flags=re.MULTILINE)
