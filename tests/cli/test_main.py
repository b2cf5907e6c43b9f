"""The command line answers in sentences and exit codes."""

import errno
import subprocess
import sys
from pathlib import Path

import pytest

from vegrip import cli
from vegrip.errors import ConfigError, DeviceError, InputError, UsageError, VegripError
from vegrip.model import paper_model, write_model


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

    monkeypatch.setattr("vegrip.cli.doctor.doctor", fail)
    assert cli.main(["doctor"]) == code
    assert capsys.readouterr().err.strip() == "vegrip: hand.toml: the key 'radius' is missing"


@pytest.mark.parametrize("limit", [5, 12, 24])
def test_too_few_descriptors_are_one_sentence_and_not_the_end_of_a_library(limit, tmp_path):
    command = f'ulimit -n {limit}; exec "{sys.executable}" -m vegrip record -o "{tmp_path}/r"'
    done = subprocess.run(["/bin/sh", "-c", command], capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 4
    assert done.stderr.startswith(f"vegrip: only {limit} files may be open at once")
    assert len(done.stderr.splitlines()) == 1


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EROFS, errno.EDQUOT])
def test_a_disk_that_takes_no_more_is_one_sentence(number, monkeypatch, capsys):
    def fill(*_):
        raise OSError(number, "No space left on device")

    monkeypatch.setattr("vegrip.identification.samples.write_whole", fill)
    monkeypatch.setattr("vegrip.cli.sample.claim_file", lambda *_, **__: None)
    assert cli.main(["sample", "press.csv", "-o", "absent.csv"]) == 4
    assert capsys.readouterr().err == "vegrip: the result is not written (No space left on device)\n"


def test_running_out_of_descriptors_later_is_one_sentence(monkeypatch, capsys):
    def run_out():
        raise OSError(errno.EMFILE, "Too many open files")

    monkeypatch.setattr("vegrip.cli.doctor.doctor", run_out)
    assert cli.main(["doctor"]) == 4
    assert capsys.readouterr().err.startswith("vegrip: too many files and sockets are open")


def test_a_missing_file_of_vegrip_itself_is_not_blamed_on_the_folder_of_the_user(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def read(*_: object) -> None:
        absent.read_text()

    monkeypatch.setattr("vegrip.export.write_export", read)
    write_model(paper_model(8e-3), tmp_path / "model.toml")
    arguments = ["export", "c", str(tmp_path / "model.toml"), "-o", str(tmp_path / "fw")]
    absent = Path(cli.__file__).parents[1] / "export" / "templates" / "absent.tmpl"
    assert cli.main(arguments) == 4
    assert (
        capsys.readouterr().err == f"vegrip: {absent}: this file of vegrip is missing; install vegrip again\n"
    )
    absent = tmp_path / "fw" / "Makefile"
    assert cli.main(arguments) == 3
    assert (
        capsys.readouterr().err == f"vegrip: {tmp_path}/fw: cannot be written (No such file or directory)\n"
    )


def test_a_bus_is_not_recorded_for_ever_where_seconds_were_given(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert cli.main(["record", "--seconds", "6"]) == 2
    assert "--seconds belongs to --node" in capsys.readouterr().err
