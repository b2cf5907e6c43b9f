"""The example of the README is a program that grips."""

import contextlib
import io
import re
from pathlib import Path

README = Path(__file__).parents[1] / "README.md"


def test_the_example_runs_and_commands_every_finger() -> None:
    (program,) = re.findall(
        r"^```python\n(.*?)^```", README.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL
    )
    told = io.StringIO()
    with contextlib.redirect_stdout(told):
        exec(compile(program, "README.md", "exec"), {})  # noqa: S102
    lines = told.getvalue().splitlines()
    assert [line.partition(":")[0] for line in lines] == ["thumb", "index"]
    for line in lines:
        found = re.fullmatch(r"\w+: grip (\d+\.\d+) N \((\w+)\), a = (\d\.\d+) mm, margin > (\d\.\d+)", line)
        assert found, line
        grip, reason, radius, margin = found.groups()
        assert 0.3 <= float(grip) < 5.0
        assert reason in ("HOLD", "LOWER", "RAISE", "FORECAST", "RATE_LIMIT", "MIN_LIMIT")
        assert 1.0 < float(radius) < 9.0
        assert 0.1 < float(margin) < 1.0


def test_every_claim_of_what_it_gains_has_a_command_beside_it() -> None:
    text = README.read_text(encoding="utf-8")
    gains = text.partition("## What it gains")[2].partition("\n## ")[0]
    claims = re.split(r"^\* ", gains, flags=re.MULTILINE)[1:]
    assert len(claims) >= 5
    assert [claim for claim in claims if not re.search(r"`(?:vegrip|python) [^`]+`", claim)] == []
