"""Trials of the diagnosis: recordings of the virtual bench with hidden effects, and what was named."""

from validation.diagnosis_trials.cases import Case, draw_cases, make_recording
from validation.diagnosis_trials.outcome import Outcome, run_case
from validation.diagnosis_trials.tally import tally_outcomes

__all__ = ["Case", "Outcome", "draw_cases", "make_recording", "run_case", "tally_outcomes"]
