"""``vegrip doctor``: whether this machine can run a hand, and what to do where it cannot."""

from vegrip.doctor.finding import Finding, Grade, worst
from vegrip.doctor.machine import examine

__all__ = ["Finding", "Grade", "examine", "worst"]
