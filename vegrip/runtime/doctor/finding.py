"""What a check found: a grade, a sentence, and the remedy."""

from collections.abc import Iterable
from dataclasses import dataclass
from enum import IntEnum


class Grade(IntEnum):
    """How well it is."""

    OK = 0
    WARN = 1  # it runs, but may miss deadlines, or something is left unused
    FAIL = 2  # it will not run


@dataclass(frozen=True, slots=True)
class Finding:
    """One line of the report."""

    check: str
    grade: Grade
    text: str
    remedy: str = ""  # what to type or set; "" when there is nothing to do


def worst(findings: Iterable[Finding]) -> Grade:
    return max((finding.grade for finding in findings), default=Grade.OK)


def ok(check: str, text: str) -> Finding:
    return Finding(check, Grade.OK, text)


def warn(check: str, text: str, remedy: str) -> Finding:
    return Finding(check, Grade.WARN, text, remedy)


def fail(check: str, text: str, remedy: str) -> Finding:
    """Return a finding that must be fixed."""
    return Finding(check, Grade.FAIL, text, remedy)
