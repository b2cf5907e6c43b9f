"""A hand in C and one in Python that know nothing but the contract grip with the node."""

import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLE = Path(__file__).parents[2] / "examples" / "hand_from_contract" / "run.py"


@pytest.mark.long
def test_hands_written_from_the_contract_alone_are_commanded_and_hold(tmp_path):
    done = subprocess.run(
        [sys.executable, str(EXAMPLE)], cwd=tmp_path, capture_output=True, text=True, check=False, timeout=300
    )
    assert done.returncode == 0, done.stderr
    assert "Python, ZeroMQ: {'commands'" in done.stdout
    assert "C, CAN: " in done.stdout
