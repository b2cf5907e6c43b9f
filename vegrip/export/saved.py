"""What firmware saved of a finger, read back into Python."""

import hashlib
import zlib
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from vegrip.errors import InputError
from vegrip.estimator import ContactEstimator, EstimatorSettings, SensorNoise
from vegrip.estimator.compiled import text_of
from vegrip.estimator.saved_numbers import SavedNumbers
from vegrip.model import ContactModel
from vegrip.whole_file import reading

LARGEST_FILE = 1 << 20  # [bytes]
NUMBER_DIGITS = 12
"""Hexadecimal digits of the text's hash that a double holds exactly."""
HEAD, TAIL = 2, 1
"""Numbers before those of the memory, mark and whether the finger had begun, and behind them, a checksum."""


def numbers_of(estimator: ContactEstimator) -> NDArray[np.float64]:
    places = SavedNumbers(estimator.model, estimator.layout).places
    return packed(_mark(estimator), estimator.memory[places])


def packed(mark: float, numbers: NDArray[np.float64]) -> NDArray[np.float64]:
    whole = np.array([mark, 1.0, *np.where(np.isnan(numbers), np.nan, numbers)])  # NaN of one kind
    return np.append(whole, checksum(whole))


def checksum(numbers: NDArray[np.float64]) -> float:
    return float(zlib.crc32(numbers.astype("<f8").tobytes()))


def resumed(estimator: ContactEstimator, numbers: NDArray[np.float64]) -> None:
    """Let ``estimator`` go on from saved numbers, as ``PREFIX_load()`` does."""
    if numbers.size <= HEAD or numbers[0] != _mark(estimator):
        raise InputError("these numbers were saved by the export of another model, or by another version")
    memory, places = estimator.memory, SavedNumbers(estimator.model, estimator.layout).places
    is_whole = numbers.size == HEAD + len(places) + TAIL and numbers[1] in (0.0, 1.0)
    if not is_whole or numbers[-1] != checksum(numbers[:-TAIL]):
        raise InputError("these numbers are damaged: they are not as they were saved")
    memory[places] = numbers[HEAD:-TAIL]
    estimator.resume(memory)


def learned_model(
    model: ContactModel,
    numbers: NDArray[np.float64],
    noise: SensorNoise | None = None,
    settings: EstimatorSettings | None = None,
) -> ContactModel:
    """Return ``model`` with the learned values and standard deviations in saved numbers."""
    estimator = ContactEstimator(model, noise or SensorNoise(), settings)
    resumed(estimator, numbers)
    places = (*estimator.layout.learned, estimator.layout.mu)
    for symbol in [name for i, name in enumerate(model.parameters) if i in places]:
        found, before = estimator.value(symbol), model.values[symbol]
        value = min(max(found.value, before.low), before.high)
        model = model.with_value(symbol, value, std=found.std)
    return model


def read_numbers(path: Path) -> NDArray[np.float64]:
    """Read saved numbers: raw little-endian doubles, or text, a decimal or hexadecimal number a line."""
    with reading(path), path.open("rb") as stream:
        data = stream.read(LARGEST_FILE + 1)
    if len(data) > LARGEST_FILE:
        raise InputError(f"{path}: is too large for the numbers of a finger")
    try:
        return np.array([_number(word) for word in data.decode("ascii").split()])
    except (UnicodeDecodeError, ValueError):
        pass
    if len(data) % 8:
        raise InputError(f"{path}: holds neither doubles of 8 bytes nor numbers as text")
    return np.frombuffer(data, dtype="<f8").copy()


def _number(word: str) -> float:
    named = {"NAN": "nan", "INFINITY": "inf", "(-INFINITY)": "-inf"}.get(word, word)
    return float.fromhex(named) if "0x" in named.lower() else float(named)


def text_number(digest: str) -> float:
    """Return the beginning of a hash as a number: it marks saved numbers."""
    return float(int(digest[:NUMBER_DIGITS], 16))


def _mark(estimator: ContactEstimator) -> float:
    text = text_of(estimator.model, estimator.layout, ellipse=estimator.settings.surface == "ellipse")
    return text_number(hashlib.sha256(text.encode()).hexdigest())
