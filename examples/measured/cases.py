"""The recordings, and the node run over one of them."""

import os
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from vegrip.estimator import ContactEstimator
from vegrip.grip.node import GraspForce
from vegrip.identification.recording import Recording
from vegrip.identification.recording.column_map import read_column_map
from vegrip.identification.recording.import_csv import import_csv
from vegrip.identification.recording.session import read_output
from vegrip.identification.recording.writer import RecordingWriter
from vegrip.runtime.replay.plot import draw_replay
from vegrip.runtime.replay.run import Outcome, grasp_node, read_settings, run_through

HERE = Path(__file__).parent
MAPS = HERE.parent / "maps"
DATA = Path(os.environ.get("VEGRIP_DATA", HERE.parents[2] / "shared" / "data"))

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Case:
    """One recording, how it is read and which node runs over it."""

    name: str
    file: str
    column_map: str
    parameters: str  # of the node, a file beside this one or a path without its suffix
    window: tuple[float, float]  # [s] in the recording where errors are told: the hold, if there is one.
    # What comes after it is left out of the numbers: a retraction that sticks would change what was learned.


SILICONE = Case(
    "silicone, 5 mm", "silicone-indent/relax_P002-laser-2.csv", "silicone_hold", "silicone", (31.0, 40.5)
)
DEEP = Case(
    "silicone, 17.75 mm",
    "silicone-indent/relax_P002-laser-1.csv",
    "silicone_hold",
    "silicone",
    (107.1, 117.2),
)
SKIN = Case("skin, 400 mN", "skin-force-hold/22-01-18_400mN.csv", "skin", "skin", (0.985, 1.155))
OOCYTE = Case("oocyte, run 1", "afm-hold/oocyte_relax_0001.csv", "afm_oocyte", "oocyte", (2.02, 31.98))
GEL = Case(
    "gel, known sphere", "afm-hold/chiaro_AEBP1_indent_002.csv", "afm_chiaro", "chiaro", (10.75, 12.65)
)
CASES = (SILICONE, DEEP, SKIN, OOCYTE, GEL)


@dataclass(frozen=True)
class Result:
    """What came of a case up to the end of its window; all times count as in the recording."""

    recording: Recording
    outcome: Outcome
    contact: dict[str, Array]  # columns of ContactEstimate
    learned: dict[str, tuple[float, float]]  # at the end: value, standard deviation of the coordinate
    alone: Array  # [N] force of the model with these values, from the measured displacement only

    def told(self) -> dict[str, object]:
        """The summary of the finger."""
        summary: dict[str, object] = self.outcome.as_dict()["fingers"]["index"]
        return summary

    def estimated_force(self) -> Array:
        """The node's normal force [N] at the instants of the recording."""
        return np.interp(self.recording.t, self.contact["t"], self.contact["normal_force"])

    def error(self, force: Array, window: tuple[float, float]) -> float:
        """Return the rms error [N] of ``force`` within ``window`` [s]."""
        rows = (self.recording.t >= window[0]) & (self.recording.t <= window[1])
        return rms((force - self.recording.columns["normal_force"])[rows])


def read(case: Case) -> Recording:
    """Import the recording of ``case``."""
    return import_csv(DATA / case.file, read_column_map(MAPS / f"{case.column_map}.toml"))


def run(case: Case, recording: Recording) -> Result:
    """Run the node over ``recording`` up to the end of the window."""
    recording = recording.select(recording.t <= case.window[1])
    node = grasp_node(read_settings(HERE / f"{case.parameters}.toml"), {"index": recording})
    found: list[ContactEstimator] = []

    def at_end() -> None:
        assert isinstance(node, GraspForce)  # noqa: S101
        estimator = node.fingers["index"].estimator
        assert isinstance(estimator, ContactEstimator)  # noqa: S101
        found.append(estimator)

    with tempfile.TemporaryDirectory() as folder:
        with RecordingWriter(Path(folder) / "session") as writer:
            outcome = run_through(node, {"index": recording}, writer=writer, at_end=at_end)
        contact = read_output(writer.folder / "index" / "contact.csv")
    learned, alone = _left_alone(found[0], recording)
    return Result(recording, outcome, contact, learned, alone)


def picture(case: Case, path: Path) -> None:
    """Draw what the node says of the whole recording."""
    recording = read(case)
    node = grasp_node(read_settings(HERE / f"{case.parameters}.toml"), {"index": recording})
    with tempfile.TemporaryDirectory() as folder:
        with RecordingWriter(Path(folder) / "session", sensors=recording.sensors) as writer:
            run_through(node, {"index": recording}, writer=writer)
        draw_replay(writer.folder / "index", path, case.name)


def _left_alone(
    estimator: ContactEstimator, recording: Recording
) -> tuple[dict[str, tuple[float, float]], Array]:
    """Return what was learned, and the force the model gives with it when no measured force corrects it."""
    model, learned = estimator.model, {}
    for symbol, value in model.values.items():
        if value.learn and symbol != "mu":
            now = estimator.value(symbol)
            learned[symbol] = (now.value, now.std)
            model = model.with_value(symbol, now.value)
    return learned, model.simulate(recording.t, recording.columns["displacement"]).normal_force


def rms(values: Array) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def si(force: float) -> str:
    """A force in the unit that reads best."""
    for unit, factor in (("N", 1.0), ("mN", 1e3), ("nN", 1e9)):
        if force * factor >= 1.0:
            return f"{force * factor:.3g} {unit}"
    return f"{force * 1e9:.2g} nN"
