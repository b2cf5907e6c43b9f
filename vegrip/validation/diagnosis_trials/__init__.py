"""Trials of the diagnosis: recordings of the virtual bench with hidden effects, and what was named."""

from vegrip.validation.diagnosis_trials.cases import Case, cases, recorded
from vegrip.validation.diagnosis_trials.outcome import Outcome, outcome
from vegrip.validation.diagnosis_trials.tally import tally

__all__ = ["Case", "Outcome", "cases", "outcome", "recorded", "tally"]
