"""The export as an Arduino library and a Zephyr module: the rules of their layouts, and what compiles here.

Neither Arduino's tools nor Zephyr are here: ``stubs`` stand for their headers and build system, and declare
what an export uses of them.
"""

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.export.firmware import run
from vegrip.c99 import host
from vegrip.export.measure import STRICT

STUBS = Path(__file__).parent / "stubs"
KINDS = [("estimator", "float"), ("finger", "double")]
"""Each entry and each precision; the C of all four is compiled in ``test_every_entry.py``."""


@pytest.fixture(scope="module", params=KINDS, ids=["-".join(kind) for kind in KINDS])
def exported(request: pytest.FixtureRequest, unmeasured: Callable[[str, str], Path]) -> tuple[Path, str]:
    entry, precision = request.param
    return unmeasured(entry, precision), f"lh_{entry}"


def properties(path: Path) -> dict[str, str]:
    return dict(line.split("=", 1) for line in path.read_text().splitlines())


def test_the_arduino_library_is_whole_and_named_by_the_rules(exported: tuple[Path, str]) -> None:
    folder, name = exported
    library = folder / "arduino" / name
    told = properties(library / "library.properties")
    assert told["name"] == library.name
    assert re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9 _.-]{0,62}", told["name"])
    assert re.fullmatch(r"\d+\.\d+\.\d+", told["version"])
    assert set(told) >= {"author", "maintainer", "sentence", "paragraph", "category", "architectures"}
    assert (library / "src" / told["includes"]).is_file()
    for file in (library / "src").iterdir():
        assert file.read_text() == (folder / file.name).read_text()
    assert {file.suffix for file in (library / "src").iterdir()} == {".h", ".c"}
    for sketch in (library / "examples").iterdir():
        assert (sketch / f"{sketch.name}.ino").is_file()


def test_the_arduino_sketch_is_sound_cpp(exported: tuple[Path, str]) -> None:
    compiler = shutil.which("g++")
    if compiler is None:
        pytest.skip("no g++")
    folder, name = exported
    library = folder / "arduino" / name
    (sketch,) = library.glob("examples/*/*.ino")
    flags = (
        "-std=gnu++11",
        "-fsyntax-only",
        "-Wall",
        "-Wextra",
        "-Werror",
        "-x",
        "c++",
        "-include",
        "Arduino.h",
    )
    done = run(compiler, *flags, f"-I{STUBS / 'arduino'}", f"-I{library / 'src'}", sketch, where=folder)
    assert done.returncode == 0, done.stderr


def test_the_library_refuses_a_double_of_four_bytes(exported: tuple[Path, str]) -> None:
    folder, name = exported
    compiler = host.compiler()
    if compiler is None:
        pytest.skip("no C compiler")
    small = ("-U__SIZEOF_DOUBLE__", "-D__SIZEOF_DOUBLE__=4")
    done = run(compiler, *host.EXACT, *small, "-fsyntax-only", f"{name}.c", where=folder)
    is_double = "float" not in (folder / f"{name}.h").read_text().split("typedef")[1]
    assert (done.returncode != 0) == is_double
    assert ("--precision float" in done.stderr) == is_double


def test_the_library_refuses_an_arduino_of_eight_bits(exported: tuple[Path, str]) -> None:
    """Built by avr-gcc it would call functions that its library does not have."""
    folder, name = exported
    compiler = host.compiler()
    if compiler is None:
        pytest.skip("no C compiler")
    done = run(compiler, *host.EXACT, "-D__AVR__", "-fsyntax-only", f"{name}.c", where=folder)
    assert done.returncode != 0
    assert "take a processor of 32 bits" in done.stderr


def test_the_zephyr_sample_configures_and_compiles(exported: tuple[Path, str], tmp_path: Path) -> None:
    if shutil.which("cmake") is None or host.compiler() is None:
        pytest.skip("no cmake or no C compiler")
    folder, name = exported
    sample, stub = folder / "zephyr" / "sample", STUBS / "zephyr"
    strict = " ".join(flag for flag in STRICT if flag != "-Wconversion")
    given = (f"-DZephyr_DIR={stub}", f"-DCMAKE_C_FLAGS={strict}", f"-DCMAKE_C_COMPILER={host.compiler()}")
    made = run("cmake", "-S", sample, "-B", tmp_path, *given, where=folder)
    assert made.returncode == 0, made.stderr
    built = run("cmake", "--build", tmp_path, where=folder)
    assert built.returncode == 0, built.stdout + built.stderr
    assert list(tmp_path.rglob(f"lib{name}.a"))
    assert list(tmp_path.rglob("main.c.o"))


def test_every_option_of_the_sample_is_one_of_the_module_or_of_zephyr(exported: tuple[Path, str]) -> None:
    folder, name = exported
    kconfig = (folder / "zephyr" / "Kconfig").read_text()
    assert f"config {name.upper()}\n" in kconfig
    assert all(line.startswith(("config ", "\t")) for line in kconfig.splitlines())
    options = set(
        re.findall(r"^CONFIG_(\w+)=", (folder / "zephyr/sample/prj.conf").read_text(), re.MULTILINE)
    )
    of_zephyr = {"CAN", "CAN_FD_MODE", "MAIN_STACK_SIZE", "SYS_CLOCK_TICKS_PER_SEC", "PRINTK"}
    assert name.upper() in options
    assert options - {name.upper()} <= of_zephyr
    assert f"CONFIG_{name.upper()}" in (folder / "zephyr" / "CMakeLists.txt").read_text()


def test_the_plain_build_by_cmake_passes_its_self_test(exported: tuple[Path, str], tmp_path: Path) -> None:
    if shutil.which("cmake") is None or host.compiler() is None:
        pytest.skip("no cmake or no C compiler")
    folder, name = exported
    made = run("cmake", "-S", folder, "-B", tmp_path, "-DCMAKE_BUILD_TYPE=Debug", where=folder)
    assert made.returncode == 0, made.stderr
    assert run("cmake", "--build", tmp_path, where=folder).returncode == 0
    tested = run("ctest", "--test-dir", tmp_path, "--output-on-failure", where=folder)
    assert tested.returncode == 0, tested.stdout
    assert list(tmp_path.rglob(f"lib{name}.a"))
