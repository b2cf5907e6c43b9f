"""The exported estimator builds anywhere, and says what Python's says."""

import json
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from tests.export.worst_inputs import assert_search_finds_more_than_recorded
from vegrip.c99 import host
from vegrip.cli import main
from vegrip.errors import InputError, UsageError
from vegrip.estimator import ContactEstimator, SensorNoise
from vegrip.export import Exported, Request, write_export
from vegrip.export.measure import STRICT, deepest, stack_frames
from vegrip.export.saved import learned_model, numbers_of, read_numbers, resumed
from vegrip.export.vectors import FLAGS, record, simulated
from vegrip.model import paper_model, read_model, write_model

needs_compiler = pytest.mark.skipif(host.compiler() is None, reason="no C compiler")
SOURCES = ("lh_estimator.c", "lh_vectors.c", "lh_selftest.c")
FRAMES = 200


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Exported]:
    folder = tmp_path_factory.mktemp("firmware")
    return folder, write_export(Request(paper_model(8e-3), prefix="lh", frames=FRAMES), folder)


def run(*command: str | Path, where: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(list(map(str, command)), cwd=where, capture_output=True, text=True, check=False)


@needs_compiler
def test_the_self_test_passes_to_the_bit(exported: tuple[Path, Exported]) -> None:
    test = exported[1].measured.host_run
    assert test is not None
    assert test.passed
    assert test.frames == FRAMES
    assert test.equal == test.numbers > 20 * FRAMES
    assert test.largest == 0.0


def test_the_sequence_shows_every_flag_both_ways() -> None:
    told = [frame.flags for frame in record(Request(paper_model(8e-3))).frames]
    for bit, name in enumerate(FLAGS):
        assert {flags >> bit & 1 for flags in told} == {0, 1}, name


@needs_compiler
def test_a_wrong_number_fails_the_self_test(exported: tuple[Path, Exported], tmp_path: Path) -> None:
    folder = exported[0]
    text = (folder / "lh_estimator.c").read_text()
    wrong = re.sub(r"(#define LH_K_WIDE )1\.73\S*", r"\g<1>1.7321", text)
    assert wrong != text
    (tmp_path / "lh_estimator.c").write_text(wrong)
    compiler = str(host.compiler())
    sources = [tmp_path / "lh_estimator.c", *SOURCES[1:]]
    built = run(compiler, *host.EXACT, f"-I{folder}", *sources, "-o", tmp_path / "t", "-lm", where=folder)
    assert built.returncode == 0, built.stderr
    done = run(tmp_path / "t", where=folder)
    assert done.returncode == 1
    assert "FAIL" in done.stdout


@needs_compiler
@pytest.mark.parametrize("compiler", ["gcc", "clang"])
@pytest.mark.parametrize("source", [*SOURCES, "examples/linux.c", "examples/bare_metal.c"])
def test_no_compiler_warns(
    compiler: str, source: str, exported: tuple[Path, Exported], tmp_path: Path
) -> None:
    if shutil.which(compiler) is None:
        pytest.skip(f"no {compiler}")
    done = run(
        compiler, *host.EXACT, "-O2", *STRICT, "-I.", "-c", source, "-o", tmp_path / "o", where=exported[0]
    )
    assert done.returncode == 0, done.stderr
    assert not done.stderr


@needs_compiler
def test_no_undefined_behaviour(exported: tuple[Path, Exported], tmp_path: Path) -> None:
    checks = ("-fsanitize=undefined,address,float-cast-overflow", "-fno-sanitize-recover=all", "-g", "-O1")
    built = run(
        str(host.compiler()), *host.EXACT, *checks, *SOURCES, "-o", tmp_path / "t", "-lm", where=exported[0]
    )
    assert built.returncode == 0, built.stderr
    done = run(tmp_path / "t", where=exported[0])
    assert done.returncode == 0, done.stdout + done.stderr


CLOCKS = """
#include "lh_estimator.h"

int main(void)
{
    static const int64_t times[] = {
        0, INT64_MAX, INT64_MIN, 1, INT64_MIN + 1, -1, INT64_MAX - 1, INT64_MAX / 2, INT64_MIN / 2, 1000000,
    };
    static lh_estimator e;
    const int32_t count = (int32_t)(sizeof times / sizeof times[0]);
    for (int32_t i = 0; i < count * count; i++) {
        lh_sample s = lh_nothing_measured();
        s.normal_force = 1.0;
        s.displacement = 4e-4;
        lh_init(&e);
        for (int32_t j = 0; j < 40; j++) { /* refused, until the clock counts as started anew */
            s.stamp_ns = j < 2 ? times[i / count] : times[i % count];
            (void)lh_update(&e, &s);
            if (!(lh_age(&e) >= 0.0)) {
                return 1;
            }
        }
    }
    return 0;
}
"""


@needs_compiler
def test_no_clock_overflows_whatever_it_says(exported: tuple[Path, Exported], tmp_path: Path) -> None:
    checks = ("-fsanitize=undefined,address,float-cast-overflow", "-fno-sanitize-recover=all", "-g", "-O1")
    (tmp_path / "clocks.c").write_text(CLOCKS)
    sources = (tmp_path / "clocks.c", "lh_estimator.c", "-o", tmp_path / "t", "-lm")
    built = run(str(host.compiler()), *host.EXACT, *checks, "-I.", *sources, where=exported[0])
    assert built.returncode == 0, built.stderr
    done = run(tmp_path / "t", where=exported[0])
    assert done.returncode == 0, done.stderr


def test_cppcheck_finds_nothing(exported: tuple[Path, Exported]) -> None:
    if shutil.which("cppcheck") is None:
        pytest.skip("no cppcheck")
    # its rule of ignored results takes the elements of a compound literal for statements
    rules = (
        "--enable=warning,performance,portability",
        "--suppress=ignoredReturnValue",
        "--error-exitcode=1",
    )
    done = run("cppcheck", "-q", "--std=c99", *rules, *SOURCES, where=exported[0])
    assert done.returncode == 0, done.stderr


def test_it_runs_on_an_emulated_cortex_m7(exported: tuple[Path, Exported]) -> None:
    if shutil.which("arm-none-eabi-gcc") is None or shutil.which("qemu-system-arm") is None:
        pytest.skip("no arm-none-eabi-gcc or no qemu-system-arm")
    measured = exported[1].measured
    assert measured.cortex is not None
    assert measured.cortex.flash > 10_000
    assert measured.cortex_run is not None
    assert measured.cortex_run.passed
    assert measured.cortex_run.equal > 0.9 * measured.cortex_run.numbers


def test_a_search_finds_calls_that_take_more_than_the_recorded_ones(exported: tuple[Path, Exported]) -> None:
    assert_search_finds_more_than_recorded(*exported, "update")


def test_nothing_that_firmware_has_not(exported: tuple[Path, Exported]) -> None:
    text = (exported[0] / "lh_estimator.c").read_text() + (exported[0] / "lh_estimator.h").read_text()
    code = re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL)
    assert set(re.findall(r"#include\s*[<\"](\S+)[>\"]", code)) == {
        "lh_estimator.h", "math.h", "stddef.h", "stdbool.h", "stdint.h",
    }  # fmt: skip
    assert not re.search(r"\b(malloc|calloc|free|printf|goto|setjmp|errno)\b", code)
    assert not re.findall(r"^static (?!const|inline|\w+ ?\*?\w+\()", code, flags=re.MULTILINE)


@needs_compiler
def test_cmake_builds_and_tests_it(exported: tuple[Path, Exported], tmp_path: Path) -> None:
    if shutil.which("cmake") is None:
        pytest.skip("no cmake")
    assert run("cmake", "-S", exported[0], "-B", tmp_path, where=tmp_path).returncode == 0
    assert run("cmake", "--build", tmp_path, where=tmp_path).returncode == 0
    done = run("ctest", "--test-dir", tmp_path, where=tmp_path)
    assert "100% tests passed" in done.stdout


def test_saved_numbers_go_on_where_they_were() -> None:
    request = Request(paper_model(8e-3), frames=120)
    states = list(simulated(request))
    first, second = (ContactEstimator(request.model, request.noise) for _ in range(2))
    for state in states[:80]:
        first.update(state)
    resumed(second, numbers_of(first))
    assert np.array_equal(numbers_of(second), numbers_of(first))
    before = first.value("mu")
    second.update(states[80])
    assert second.in_contact == first.in_contact
    assert second.value("mu").value == pytest.approx(before.value, rel=0.05)


def test_what_was_learned_goes_back_into_a_model(tmp_path: Path) -> None:
    request = Request(paper_model(8e-3))
    estimator = ContactEstimator(request.model, request.noise)
    for state in simulated(request):
        estimator.update(state)
    raw, words = tmp_path / "finger.bin", tmp_path / "finger.txt"
    raw.write_bytes(numbers_of(estimator).astype("<f8").tobytes())
    words.write_text("\n".join(float(one).hex() for one in numbers_of(estimator)))
    for path in (raw, words):
        found = learned_model(request.model, read_numbers(path))
        assert found.values["K"].value == estimator.value("K").value
        assert found.values["mu"].std == pytest.approx(estimator.value("mu").std)
    write_model(request.model, tmp_path / "model.toml")
    command = [
        "export",
        "learned",
        str(tmp_path / "model.toml"),
        str(raw),
        "-o",
        str(tmp_path / "learned.toml"),
    ]
    assert main(command) == 0
    assert read_model(tmp_path / "learned.toml").values["K"].value == estimator.value("K").value


@pytest.mark.parametrize("damage", ["other", "short", "long", "nan", "bit", "words"])
def test_other_numbers_are_refused(damage: str, tmp_path: Path) -> None:
    estimator = ContactEstimator(paper_model(8e-3), SensorNoise())
    numbers = numbers_of(estimator)
    path = tmp_path / "finger.bin"
    if damage == "other":
        numbers[0] += 1.0
    elif damage == "short":
        numbers = numbers[:-1]
    elif damage == "long":
        numbers = np.append(numbers, 0.0)
    elif damage == "bit":
        numbers.view(np.uint64)[5] ^= 1
    elif damage == "nan":
        numbers[3] = np.nan
    path.write_bytes(b"no numbers" if damage == "words" else numbers.tobytes())
    with pytest.raises(InputError):
        resumed(estimator, read_numbers(path))


@pytest.mark.parametrize("prefix", ["", "Vg", "9x", "a-b", "int", "x" * 40, "a__b"])
def test_a_prefix_that_c_does_not_take_is_refused(prefix: str) -> None:
    with pytest.raises(UsageError, match="--prefix"):
        Request(paper_model(8e-3), prefix=prefix)


@needs_compiler
def test_the_command_writes_tells_and_does_not_replace(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_model(paper_model(8e-3), tmp_path / "m.toml")
    command = ["export", "c", str(tmp_path / "m.toml"), "-o", str(tmp_path / "fw"), "--json"]
    assert main(command) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["frames"] == 500
    assert told["largest_difference"] == 0.0
    assert told["text_bytes"] > 10_000
    assert told["stack_bytes"] > 100
    assert all(Path(path).is_file() for path in told["files"])
    assert main(command) == 3
    assert "--force" in capsys.readouterr().err
    built = run("make", "-C", tmp_path / "fw", where=tmp_path)
    assert "PASS 500 frames" in built.stdout


@pytest.mark.parametrize("wrong", [["--entry", "hand"], ["--precision", "half"], ["--prefix", "1"]])
def test_what_cannot_be_exported_is_told(wrong: list[str], tmp_path: Path) -> None:
    write_model(paper_model(8e-3), tmp_path / "m.toml")
    assert main(["export", "c", str(tmp_path / "m.toml"), "-o", str(tmp_path / "fw"), *wrong]) == 2


def test_stack_is_the_deepest_way_down() -> None:
    usage = (
        "a.c:1:2:top\t16\tstatic\na.c:9:1:left.constprop.0\t48\tstatic\na.c:12:1:right\t32\tdynamic,bounded\n"
    )
    frames = stack_frames(usage)
    assert frames == {"top": 16, "left": 48, "right": 32}
    calls = {"top": frozenset({"left", "right"}), "right": frozenset({"left"})}
    assert deepest("top", calls, frames) == 16 + 32 + 48


@pytest.fixture(scope="module")
def in_floats(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Exported]:
    folder = tmp_path_factory.mktemp("floats")
    return folder, write_export(Request(paper_model(8e-3), prefix="lh", precision="float"), folder)


@needs_compiler
def test_in_single_precision_no_estimate_is_off_by_a_fifth_of_its_error(
    in_floats: tuple[Path, Exported],
) -> None:
    test = in_floats[1].measured.host_run
    assert test is not None
    assert test.passed
    assert test.equal < test.numbers
    assert 1e-6 < test.largest < 0.2


@needs_compiler
@pytest.mark.parametrize("source", [*SOURCES, "examples/linux.c", "examples/bare_metal.c"])
def test_nothing_is_widened_to_double_in_single_precision(
    source: str, in_floats: tuple[Path, Exported], tmp_path: Path
) -> None:
    strict = (*STRICT, "-Wdouble-promotion") if source == SOURCES[0] else STRICT
    compiler = str(host.compiler())
    done = run(
        compiler, *host.EXACT, "-O2", *strict, "-I.", "-c", source, "-o", tmp_path / "o", where=in_floats[0]
    )
    assert done.returncode == 0, done.stderr


def test_single_precision_runs_on_an_emulated_cortex_m4f(in_floats: tuple[Path, Exported]) -> None:
    if shutil.which("arm-none-eabi-gcc") is None or shutil.which("qemu-system-arm") is None:
        pytest.skip("no arm-none-eabi-gcc or no qemu-system-arm")
    measured = in_floats[1].measured
    assert measured.cortex is not None
    assert measured.cortex.flash < 40_000
    assert measured.cortex_run is not None
    assert measured.cortex_run.machine == "Cortex-M4F in qemu"
    assert measured.cortex_run.passed


@needs_compiler
def test_a_folder_named_from_here_is_measured_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    measured = write_export(Request(paper_model(8e-3), frames=50), Path("firmware")).measured
    assert measured.host is not None
    assert measured.host_run is not None
    assert measured.host_run.passed
