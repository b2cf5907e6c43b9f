"""MISRA C:2012 by cppcheck: nothing but the deviations that docs/export-c.md lists with their reasons."""

import re
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs" / "export-c.md"
RULE = re.compile(r"misra-c2012-(\d+\.\d+)")


def deviations() -> set[str]:
    """Return the rules that the documentation lists."""
    text = DOCS.read_text(encoding="utf-8")
    listed = text[text.index("### MISRA C") :]
    return set(re.findall(r"^\* (\d+\.\d+): ", listed, re.MULTILINE))


def broken_rules(source: Path) -> set[str]:
    command = ["cppcheck", "-q", "--std=c99", "--addon=misra", "--enable=style", str(source)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if "misra.py" in done.stderr:
        pytest.skip("this cppcheck has no add-on for MISRA")
    return set(RULE.findall(done.stderr))


@pytest.mark.long
@pytest.mark.parametrize(("entry", "precision"), [("finger", "double"), ("estimator", "float")])
def test_no_rule_is_broken_that_is_not_a_stated_deviation(
    entry: str, precision: str, unmeasured: Callable[[str, str], Path]
) -> None:
    if shutil.which("cppcheck") is None:
        pytest.skip("no cppcheck")
    found = broken_rules(unmeasured(entry, precision) / f"lh_{entry}.c")
    assert found, "the add-on has looked"
    assert found <= deviations()


def test_the_add_on_sees_a_break(tmp_path: Path) -> None:
    if shutil.which("cppcheck") is None:
        pytest.skip("no cppcheck")
    source = tmp_path / "wrong.c"
    source.write_text("int f(void);\nint f(void) { return 077; }\n")
    assert broken_rules(source) - deviations() == {"7.1"}
