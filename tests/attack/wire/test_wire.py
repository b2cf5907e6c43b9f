"""Whatever goes over the wire, the command stays safe, the grip comes back, and it is told what was refused.

The attack itself is ``make attack``; this is a short form of it with fixed seeds: each fault on one wire.
"""

import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
KINDS = 26


def attack(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, str(HERE), *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.mark.long
def test_no_fault_on_a_wire_breaks_a_law() -> None:
    done = attack("--cases", str(KINDS))
    assert done.returncode == 0, done.stdout + done.stderr
    assert len(done.stdout.splitlines()) == KINDS


@pytest.mark.long
def test_the_attack_sees_every_node_that_is_broken_on_purpose() -> None:
    done = attack("--canaries")
    lines = done.stdout.splitlines()
    assert len(lines) == 4, done.stdout + done.stderr
    assert [line for line in lines if not line.startswith("FAILED")] == []
    assert done.returncode == 1


def test_on_can_the_attack_meets_the_compiled_step() -> None:
    told = "from rig import Rig; rig = Rig('can'); rig.run_until(1.0); print(rig.runner.frame_path.frames)"
    done = subprocess.run([sys.executable, "-c", told], capture_output=True, text=True, check=False, cwd=HERE)
    assert int(done.stdout) > 300, done.stderr
