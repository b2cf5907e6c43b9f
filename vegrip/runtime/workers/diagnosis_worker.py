"""Diagnose what a node felt, in a process of its own.

Usage: ``python -m vegrip.runtime.workers.diagnosis_worker SENSOR=STD ... < felt.npz``.

The arrays are the columns of a recording, and ``model`` is the text of the model file. The answer is one word
on standard output, empty when the model only had to be fitted anew. It makes way for everything else on the
machine.
"""

import io
import sys

import numpy as np

from vegrip.identification.diagnosis import diagnose
from vegrip.identification.recording import Fingertip, Recording
from vegrip.model import ContactModel
from vegrip.model.file import parse_model

MAX_EFFECTS = 1  # effects that are looked for: the leading suspect
UNEXPLAINED = "unexplained"


def leading_suspect(recording: Recording, model: ContactModel) -> str:
    """Return the effect that explains most of what ``model`` leaves; "unexplained" when none does."""
    found = diagnose(recording, model, most=MAX_EFFECTS, threads=1)
    if found.search.accepted:
        return found.search.accepted[0].candidate.name
    return UNEXPLAINED if found.verdict == "unexplained" else ""


def main(arguments: list[str]) -> int:
    with np.load(io.BytesIO(sys.stdin.buffer.read())) as felt:
        columns = {name: felt[name] for name in felt.files}
    model = parse_model(str(columns.pop("model")))
    t = columns.pop("t")
    sensors = {name: float(std) for name, _, std in (text.partition("=") for text in arguments)}
    episode = np.zeros(t.size, dtype=np.int64)
    recording = Recording("felt", t, episode, columns, Fingertip(model.tip_radius), sensors)
    print(leading_suspect(recording, model))  # noqa: T201
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
