"""The wheel as a user gets it: installed without extras, outside the checkout, beside a namesake folder."""

import json
import math
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tarfile
import time
import tomllib
import venv
import zipfile
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass, replace
from email import message_from_bytes
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.wheel
FENCE = re.compile(r"^```sh\n(.*?)^```", re.MULTILINE | re.DOTALL)
ENDLESS = ("launch", "monitor", "check")  # they run until Ctrl-C
CONSTRAINED = ("--disable-pip-version-check", "-c", str(ROOT / "constraints.txt"))
PATIENCE = 180.0  # [s] until the nodes of a launch file are active
LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)\)")

HELP = """
from vegrip.cli import COMMANDS, load, main
failed = []
for name in COMMANDS:
    subs = load(name).registered_commands
    for sub in [[], *([one.name or one.callback.__name__] for one in subs if len(subs) > 1)]:
        if main([name, *sub, "--help"]) != 0:
            failed.append([name, *sub])
raise SystemExit(f"no help: {failed}" if failed else 0)
"""


@dataclass(frozen=True)
class Installed:
    """An environment with the wheel and what it depends on."""

    folder: Path  # holds the environment
    wheel: Path
    source: Path  # the sdist
    work: Path  # where users work; at first beside a folder named like the package

    def __call__(self, *arguments: str, program: str = "vegrip") -> subprocess.CompletedProcess[str]:
        running = self.start(*arguments, program=program)
        output, complaints = running.communicate()
        return subprocess.CompletedProcess(arguments, running.returncode, output, complaints)

    def start(self, *arguments: str, program: str = "vegrip") -> subprocess.Popen[str]:
        kept = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
        kept |= {"VEGRIP_RUNTIME_DIR": str(self.folder / "r"), "COLUMNS": "200"}
        command = [str(self.folder / "env" / "bin" / program), *arguments]
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
        return subprocess.Popen(
            command, cwd=self.work, env=kept, text=True, start_new_session=True,
            preexec_fn=_take_interrupts, **pipes,  # noqa: PLW1509
        )  # fmt: skip


def _take_interrupts() -> None:
    """Undo what a shell does to processes in the background: they ignore Ctrl-C."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Installed]:
    folder = tmp_path_factory.mktemp("w")
    build = [sys.executable, "-m", "build", "-q", "--no-isolation", "--outdir", str(folder / "dist")]
    subprocess.run([*build, str(ROOT)], check=True, capture_output=True)
    (wheel,), (source,) = ((folder / "dist").glob(f"*.{end}") for end in ("whl", "tar.gz"))
    venv.create(folder / "env", with_pip=True)
    (folder / "vegrip" / "vegrip").mkdir(parents=True)  # as a clone lies beside a user's script
    made = Installed(folder, wheel, source, folder)
    done = made("-m", "pip", "install", "-q", *CONSTRAINED, str(wheel), program="python")
    assert done.returncode == 0, done.stderr
    yield made
    shutil.rmtree(folder)  # half a gigabyte


@pytest.fixture(scope="module")
def press(installed: Installed) -> str:
    """A recording of a press of two seconds, imported from a table: elastic, K = 2 N at 1 mm."""
    times = [i / 200 for i in range(400)]
    depths = [1e-3 * math.sin(0.5 * math.pi * t) ** 2 for t in times]
    rows = (f"{t},{d},{2.0 * (1e3 * d) ** 1.5}" for t, d in zip(times, depths, strict=True))
    text = "t,displacement,normal_force\n" + "\n".join(rows) + "\n"
    (installed.folder / "press.csv").write_text(text, encoding="utf-8")
    done = installed("import", "press.csv", "-o", "press", "--radius", "8 mm")
    assert done.returncode == 0, done.stderr
    return "press"


def test_it_is_the_installed_package_that_runs_without_any_extra(installed: Installed) -> None:
    code = (
        "import importlib.util, vegrip; from vegrip import FingertipState; print(vegrip.__file__);"
        "print([m for m in ('matplotlib', 'mcap', 'rosbags', 'distributed', 'pytest')"
        " if importlib.util.find_spec(m)])"
    )
    done = installed("-c", code, program="python")
    assert done.returncode == 0, done.stderr
    where, extras = done.stdout.splitlines()
    assert "site-packages" in where
    assert extras == "[]"


def test_every_command_and_subcommand_has_its_help(installed: Installed) -> None:
    done = installed("-c", HELP, program="python")
    assert done.returncode == 0, done.stderr
    assert installed("--help").returncode == 0
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(
    "arguments",
    [
        ("doctor", "--json"),
        ("paper", "--json"),
        ("bus-load", "--json"),
        ("launch", "demo", "--check"),
        ("launch", "canopen", "--check"),
        ("lifecycle", "list", "--json"),
        ("new-effect", "my_effect"),
    ],
    ids=" ".join,
)
def test_what_needs_no_extra_runs(installed: Installed, arguments: tuple[str, ...]) -> None:
    done = installed(*arguments)
    assert done.returncode in ((0, 4) if arguments[0] == "doctor" else (0,)), done.stderr
    assert "Traceback" not in done.stderr
    if "--json" in arguments:
        json.loads(done.stdout)


def test_a_table_is_imported_fitted_and_simulated(installed: Installed, press: str) -> None:
    for arguments in (
        ("fit", press, "-o", "press.toml"),
        ("compare", press, "--model", "press.toml", "--json"),
        ("simulate", "press.toml", "--rate", "50", "-o", "simulated"),
    ):
        done = installed(*arguments)
        assert done.returncode == 0, done.stderr
        assert "Traceback" not in done.stderr


def test_the_demo_runs_and_says_first_that_there_will_be_no_picture(installed: Installed) -> None:
    done = installed("demo", "--headless", "--json", "--duration", "3", "-o", "demo")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["samples"] > 0
    before, started, _ = done.stderr.partition("starting hand and node")
    assert started
    assert "no picture: it needs matplotlib; pip install 'vegrip[plot]'" in before


@pytest.mark.parametrize(
    ("arguments", "extra"),
    [
        (("compare", "nosuch", "-o", "pictures"), "plot"),
        (("refine", "nosuch", "--report", "ladder"), "plot"),
        (("replay", "press", "--through", "--plot", "replay.png"), "plot"),
        (("paper", "-o", "figures"), "plot"),
        (("import", "session.mcap", "-o", "session"), "bags"),
        (("import", "drive.mf4", "-o", "drive"), "mdf"),
        (("import", "drive.bag", "-o", "drive", "--map", "normal_force=/ft:force"), "bags"),
    ],
    ids=lambda value: value[0] if isinstance(value, tuple) else value,
)
def test_what_needs_an_extra_says_which_in_one_sentence_before_any_work(
    installed: Installed, press: str, arguments: tuple[str, ...], extra: str
) -> None:
    """The recording ``nosuch`` does not exist: who misses it has begun to work."""
    begin = {"session.mcap": b"\x89MCAP0\r\n", "drive.mf4": b"MDF     4.10", "drive.bag": b"#ROSBAG V2.0\n"}
    for name, content in begin.items():
        (installed.folder / name).write_bytes(content)
    done = installed(*arguments)
    assert done.returncode == 2, done.stdout + done.stderr
    assert f"pip install 'vegrip[{extra}]'" in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1, done.stderr
    assert done.stdout == ""


def _links(page: str) -> Iterator[str]:
    yield from (match[1] for match in LINK.finditer(page))


def test_benchmarks_are_in_the_source_and_it_is_said(installed: Installed) -> None:
    done = installed("bench", "estimator")
    assert done.returncode == 2
    assert "`make bench`" in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1


def test_the_page_of_the_package_has_no_link_that_leads_nowhere(installed: Installed) -> None:
    with zipfile.ZipFile(installed.wheel) as archive:
        (name,) = (name for name in archive.namelist() if name.endswith(".dist-info/METADATA"))
        metadata = message_from_bytes(archive.read(name))
    page = metadata.get_payload(decode=True).decode()
    assert metadata["Description-Content-Type"] == "text/markdown"
    assert page.lstrip().startswith("# vegrip")
    assert [link for link in _links(page) if "://" not in link and not link.startswith("#")] == []


def test_the_source_distribution_has_documents_changelog_and_tests(installed: Installed) -> None:
    with tarfile.open(installed.source) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    for name in (
        "CHANGELOG.md",
        "LICENSE",
        "docs/demo.md",
        "docs/images/demo.png",
        "Makefile",
        "constraints.txt",
    ):
        assert name in names
    assert {"tests/install/test_wheel.py", "benchmarks/hot_path.py", "validation/__init__.py"} <= names


def test_the_wheel_has_all_files_of_the_package_folders_and_no_others(installed: Installed) -> None:
    folders = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["package-dir"]
    ours = {
        (Path(name.replace(".", "/")) / path.relative_to(ROOT / folder)).as_posix()
        for name, folder in folders.items()
        for path in (ROOT / folder).rglob("*")
        if path.is_file() and path.parent.name != "__pycache__"
    }
    with zipfile.ZipFile(installed.wheel) as archive:
        shipped = {name for name in archive.namelist() if ".dist-info/" not in name}
    assert shipped == ours


@pytest.fixture(scope="module")
def with_extras(installed: Installed) -> Installed:
    """The same environment afterwards: with the extras that the README names for its commands."""
    done = installed("-m", "pip", "install", "-q", *CONSTRAINED, "vegrip[web,plot]", program="python")
    assert done.returncode == 0, done.stderr
    return installed


def commands_of_the_readme() -> Iterator[list[list[str]]]:
    """Give the calls of vegrip in each code block, without their comments."""
    for block in FENCE.findall((ROOT / "README.md").read_text(encoding="utf-8")):
        lines = block.replace("\\\n", " ").splitlines()
        yield [words[1:] for line in lines if (words := shlex.split(line, comments=True))[:1] == ["vegrip"]]


def test_every_command_of_the_readme_runs_in_an_empty_folder(with_extras: Installed, tmp_path: Path) -> None:
    """Those that run until Ctrl-C go on beside the rest of their block, as in a second terminal."""
    here = replace(with_extras, work=tmp_path)
    for block in commands_of_the_readme():
        with ExitStack() as ends:
            for words in block:
                if words[0] in ENDLESS:
                    running = here.start(*words)
                    ends.callback(_interrupted, words, running)
                    if words[0] == "launch":
                        _until_active(here, running)
                    continue
                done = here(*words)
                assert (words, done.returncode) == (words, 0), done.stderr
                assert "Traceback" not in done.stderr


def _until_active(here: Installed, launched: subprocess.Popen[str]) -> None:
    end = time.monotonic() + PATIENCE
    while "active" not in here("lifecycle", "get", "grasp_force").stdout.split():
        assert launched.poll() is None
        assert time.monotonic() < end


def _interrupted(words: list[str], running: subprocess.Popen[str]) -> None:
    assert running.poll() is None, (words, running.communicate())
    running.send_signal(signal.SIGINT)
    _, complaints = running.communicate(timeout=60)
    # by SIGINT itself where it was still being imported: a shell calls that 130, too
    assert running.returncode in (0, 130, -signal.SIGINT), (words, complaints)
    assert "Traceback" not in complaints
