"""No broken file ends a reader in another way than by a sentence, nor makes it write beside its output.

The attack itself is ``make attack``; this is a short form of it with fixed seeds.
"""

import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
pytest.importorskip("mcap", reason="the extra `bags` is not installed")
pytest.importorskip("rosbags", reason="the extra `bags` is not installed")


def attack(*arguments: str, folder: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, str(HERE), *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False, cwd=folder)


@pytest.mark.long
def test_every_broken_file_is_read_or_refused_in_a_sentence_and_nothing_else_is_touched(
    tmp_path: Path,
) -> None:
    done = attack("--cases", "6", folder=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.long
def test_the_attack_finds_every_reader_that_is_broken_on_purpose(tmp_path: Path) -> None:
    done = attack("--canaries", "--cases", "1", folder=tmp_path)
    lines = [line for line in done.stdout.splitlines() if line.endswith("s") and " failed, slowest " in line]
    assert len(lines) == 8, done.stdout + done.stderr
    assert [line for line in lines if not line.startswith("FAILED")] == []
    assert done.returncode == 1
