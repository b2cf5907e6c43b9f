"""``vegrip doctor``: whether this machine can run a hand, and what to do where it cannot."""

from vegrip.runtime.doctor.finding import Finding, Grade, worst
from vegrip.runtime.doctor.machine import examine

__all__ = ["Finding", "Grade", "examine", "worst"]
