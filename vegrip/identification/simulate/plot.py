"""A picture of a protocol: what is imposed and what a model answers, episode by episode."""

from pathlib import Path

import numpy as np

from vegrip.identification.recording import Recording
from vegrip.identification.simulate.protocol import Protocol
from vegrip.identification.simulate.run import DEFAULT_NOISE, simulate
from vegrip.model import ContactModel
from vegrip.plotting import new_figure, save_figure

EPISODE_GAP_SHARE = 0.02  # of the duration, drawn between episodes in place of the pause


def draw_simulation(protocol: Protocol, models: dict[str, ContactModel], path: Path) -> None:
    """Draw ``protocol`` with the forces that ``models`` (by name) answer, and how they differ.

    Raises:
        UsageError: matplotlib is not installed.
        InputError: the picture cannot be written.

    """
    exact = dict.fromkeys(DEFAULT_NOISE, 0.0)
    found = {name: simulate(model, protocol, sensors=exact) for name, model in models.items()}
    one = next(iter(found.values()))
    t, loads = _drawn_time(one), bool(np.any(one.columns["slip"] > 0.0))
    rows = 2 + (len(found) > 1) + loads
    figure, axes = new_figure(rows, size=(10, 2.1 * rows), share_x=True)
    axes[0].plot(t, 1e3 * _cut(one, one.columns["displacement"]), "k", lw=1)
    axes[0].set_ylabel("depth [mm]")
    axes[0].set_title(f"{protocol.name}, {protocol.duration:.0f} s with pauses of {protocol.pause:g} s")
    for name, recording in found.items():
        axes[1].plot(t, _cut(recording, recording.columns["normal_force"]), lw=1, label=name)
    axes[1].set_ylabel("normal force [N]")
    axes[1].legend(fontsize=8)
    if len(found) > 1:
        base = one.columns["normal_force"]
        for i, (name, recording) in enumerate(found.items()):
            if i:
                difference = 1e3 * (recording.columns["normal_force"] - base)
                axes[2].plot(
                    t, _cut(one, difference), lw=1, color=f"C{i}", label=f"{name} - {next(iter(found))}"
                )
        axes[2].set_ylabel("before refits [mN]")
        axes[2].legend(fontsize=8)
    if loads:
        axes[-1].plot(
            t, _cut(one, np.hypot(one.columns["tangential_force_x"], one.columns["tangential_force_y"])), lw=1
        )
        axes[-1].set_ylabel("tangential [N]")
    axes[-1].set_xlabel("time without the pauses [s]")
    save_figure(figure, path)


def _drawn_time(recording: Recording) -> np.ndarray:
    """Return the time without pauses, one NaN row between episodes."""
    step = float(np.median(np.diff(recording.t)))
    length = len(recording) * step
    shift = np.r_[0, np.cumsum(np.diff(recording.episode) != 0)] * EPISODE_GAP_SHARE * length
    return _cut(recording, step * np.arange(len(recording)) + shift)


def _cut(recording: Recording, values: np.ndarray) -> np.ndarray:
    """Return ``values`` with a gap where an episode begins, so that no line crosses it."""
    starts = np.flatnonzero(np.diff(recording.episode)) + 1
    return np.insert(values.astype(float), starts, np.nan)
