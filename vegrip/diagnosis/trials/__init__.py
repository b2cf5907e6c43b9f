"""Trials of the diagnosis: recordings of the virtual bench with hidden effects, and what was named."""

from vegrip.diagnosis.trials.cases import Case, cases, recorded
from vegrip.diagnosis.trials.outcome import Outcome, outcome
from vegrip.diagnosis.trials.tally import tally

__all__ = ["Case", "Outcome", "cases", "outcome", "recorded", "tally"]
