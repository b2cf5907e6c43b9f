"""Places of the same material that differ in stiffness: whether the rest of a model carries over."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from vegrip.identification.fit import fit, noise_of
from vegrip.identification.recording import read_recording
from vegrip.model import read_model


def own_stiffness(folder: Path, models: tuple[str, ...], options: tuple[str, ...]) -> list[float]:
    """Return for each model the rms error over all places when only K (and the zeros) fit a place."""
    tolerance = float(options[options.index("--tolerance") + 1])
    recording = read_recording(folder)
    noise = noise_of(recording).tolerant(tolerance)
    errors = []
    for file in models:
        model = read_model(file)
        for symbol in model.parameters:
            if symbol != "K":
                model = model.with_value(symbol, model.values[symbol].value, std=0.0)
        model = replace(model, values={**model.values, "K": replace(model.values["K"], std=1.0)})
        errors.append([fit(place, model, noise=noise).error for place in recording.episodes()])
    return [float(np.sqrt(np.mean(np.square(one)))) for one in errors]
