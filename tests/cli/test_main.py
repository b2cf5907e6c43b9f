"""The command line answers in sentences and exit codes."""

import errno
import subprocess
import sys
import types

import pytest

from vegrip import cli
from vegrip.errors import ConfigError, DeviceError, InputError, UsageError, VegripError


def test_help_lists_every_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["--help"]) == 0
    shown = capsys.readouterr().out
    assert all(f"vegrip {name}" in shown for name in cli.COMMANDS)


def test_an_unknown_command_is_a_usage_error(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["gripp"]) == 2
    assert "there is no command 'gripp'" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("error", "code"),
    [(UsageError, 2), (InputError, 3), (ConfigError, 3), (DeviceError, 4), (VegripError, 1)],
)
def test_an_error_becomes_one_sentence_and_its_exit_code(
    error: type[VegripError], code: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail() -> None:
        raise error("hand.toml: the key 'radius' is missing")

    module = types.ModuleType("failing")
    module.fail = fail  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "failing", module)
    monkeypatch.setitem(cli.COMMANDS, "fail", ("failing:fail", "Fails."))
    assert cli.main(["fail"]) == code
    assert capsys.readouterr().err.strip() == "vegrip: hand.toml: the key 'radius' is missing"


@pytest.mark.parametrize("limit", [5, 12, 24])
def test_too_few_descriptors_are_one_sentence_and_not_the_end_of_a_library(limit, tmp_path):
    command = f'ulimit -n {limit}; exec "{sys.executable}" -m vegrip record -o "{tmp_path}/r"'
    done = subprocess.run(["/bin/sh", "-c", command], capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 4
    assert done.stderr.startswith(f"vegrip: only {limit} files may be open at once")
    assert len(done.stderr.splitlines()) == 1


def test_running_out_of_descriptors_later_is_one_sentence(monkeypatch, capsys):
    def run_out():
        raise OSError(errno.EMFILE, "Too many open files")

    monkeypatch.setattr("vegrip.cli.doctor.doctor", run_out)
    assert cli.main(["doctor"]) == 4
    assert capsys.readouterr().err.startswith("vegrip: too many files and sockets are open")
