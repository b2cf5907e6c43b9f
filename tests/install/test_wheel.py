"""The wheel as a user gets it: installed without extras, outside the checkout, beside a namesake folder."""

import json
import math
import os
import re
import shutil
import subprocess
import sys
import tarfile
import venv
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from email import message_from_bytes
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.wheel
LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)\)")

HELP = """
import importlib
from vegrip.cli import COMMANDS, main
failed = []
for name, (place, _) in COMMANDS.items():
    module, attribute = place.split(":")
    subs = getattr(getattr(importlib.import_module(module), attribute), "registered_commands", [])
    for sub in [[], *([one.name or one.callback.__name__] for one in subs)]:
        if main([name, *sub, "--help"]) != 0:
            failed.append([name, *sub])
raise SystemExit(f"no help: {failed}" if failed else 0)
"""


@dataclass(frozen=True)
class Installed:
    """An environment with the wheel and what it depends on."""

    folder: Path  # where users work; holds a folder named like the package
    wheel: Path
    source: Path  # the sdist

    def __call__(self, *arguments: str, program: str = "vegrip") -> subprocess.CompletedProcess[str]:
        kept = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
        kept |= {"VEGRIP_RUNTIME_DIR": str(self.folder / "r"), "COLUMNS": "200"}
        command = [str(self.folder / "env" / "bin" / program), *arguments]
        return subprocess.run(command, cwd=self.folder, env=kept, capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Installed]:
    folder = tmp_path_factory.mktemp("w")
    build = [sys.executable, "-m", "build", "-q", "--no-isolation", "--outdir", str(folder / "dist")]
    subprocess.run([*build, str(ROOT)], check=True, capture_output=True)
    (wheel,), (source,) = ((folder / "dist").glob(f"*.{end}") for end in ("whl", "tar.gz"))
    venv.create(folder / "env", with_pip=True)
    (folder / "vegrip" / "vegrip").mkdir(parents=True)  # as a clone lies beside a user's script
    made = Installed(folder, wheel, source)
    pip = ("-m", "pip", "install", "-q", "--disable-pip-version-check", "-c", str(ROOT / "constraints.txt"))
    done = made(*pip, str(wheel), program="python")
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
        ("bench", "recursion", "--json"),
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
        (("import", "drive.bag", "-o", "drive", "--map", "normal_force=/ft:force"), "bags"),
    ],
    ids=lambda value: value[0] if isinstance(value, tuple) else value,
)
def test_what_needs_an_extra_says_which_in_one_sentence_before_any_work(
    installed: Installed, press: str, arguments: tuple[str, ...], extra: str
) -> None:
    """The recording ``nosuch`` does not exist: who misses it has begun to work."""
    for name in ("session.mcap", "drive.bag"):
        (installed.folder / name).write_bytes(
            b"\x89MCAP0\r\n" if name.endswith("mcap") else b"#ROSBAG V2.0\n"
        )
    done = installed(*arguments)
    assert done.returncode == 2, done.stdout + done.stderr
    assert f"pip install 'vegrip[{extra}]'" in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1, done.stderr
    assert done.stdout == ""


def _links(page: str) -> Iterator[str]:
    yield from (match[1] for match in LINK.finditer(page))


def test_a_benchmark_without_its_peer_names_the_extra_and_is_no_success(installed: Installed) -> None:
    done = installed("bench", "estimator")
    assert done.returncode in (2, 4)
    assert "pip install 'vegrip[dev]'" in done.stderr
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
    assert "tests/install/test_wheel.py" in names
