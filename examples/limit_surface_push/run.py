"""Real pushes of a block, predicted from its pressure on the plate, and where a smooth profile fails.

    python examples/limit_surface_push/run.py [FOLDER]

prints the table of docs/limit-surface.md and draws its picture into FOLDER (default: out). The measurements
(Zhou, Paolini, Bagnell, Mason 2016) are not part of the project; VEGRIP_DATA says where they are.
"""

import os
import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np
from pushes import (
    CORNERS,
    NEAR,
    SUPPORTS,
    Array,
    Mapped,
    Pushes,
    Smooth,
    Surface,
    judge,
    read_pushes,
    rim,
    slip_centres,
)
from scipy.optimize import minimize_scalar

mpl.use("Agg")
from matplotlib import pyplot as plt

DATA = (
    Path(os.environ.get("VEGRIP_DATA", Path(__file__).parents[3] / "shared" / "data")) / "limit-surface-push"
)
THREE_FEET = tuple(name for name in SUPPORTS if "3pt" in name)
HERTZ_SIZE = np.sqrt(2 / 5)  # root mean square distance from the centre of a Hertz contact, over its radius


SKIPPED = 77  # exit code of a run without its data


def main() -> int:
    """Print the table, draw the picture."""
    if not DATA.is_dir():
        print(f"skipped: there are no measured pushes in {DATA}; set VEGRIP_DATA")
        return SKIPPED
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
    folder.mkdir(parents=True, exist_ok=True)
    print(f"{'pushes':22}{'pressure':26}{'mu N':>7}{'limit':>9}{'slip':>9}{'load':>8}")
    print(f"{'':48}{'[N]':>7}{'scatter':>9}{'angle':>9}{'error':>8}")
    for name in SUPPORTS:
        pushes = read_pushes(DATA, name)
        for title, surface in surfaces(name, pushes).items():
            e = judge(surface, pushes, SUPPORTS[name].size)
            errors = f"{e.friction:7.2f}{e.limit_scatter:9.1%}{e.slip_angle:5.1f} deg{e.load_error:8.1%}"
            print(f"{name:22}{title:26}{errors}")
    draw(folder / "limit-surface-push.png")
    return 0


def surfaces(name: str, pushes: Pushes) -> dict[str, Surface]:
    """The support as it is, and the smooth profile: of the same size, and of the radius that suits best."""
    support = SUPPORTS[name]
    known = "three feet" if name in THREE_FEET else "even over the face"
    found: dict[str, Surface] = {known: Mapped(support)}
    if name not in THREE_FEET:
        found["on the rim of the face"] = Mapped(rim())
    found["smooth, same size"] = Smooth(support.size / HERTZ_SIZE)
    found["smooth, best radius"] = best_smooth(pushes, support.size)
    return found


def best_smooth(pushes: Pushes, size: float) -> Smooth:
    """The smooth profile with the least slip angles, found with the very pushes it is then judged by."""
    found = minimize_scalar(
        lambda a: judge(Smooth(a), pushes, size).slip_angle, bounds=(0.5 * size, 4 * size), method="bounded"
    )
    return Smooth(float(found.x))


def draw(path: Path) -> None:
    """Where the block turns: measured, by its feet, by the smooth profile of the same size."""
    figure, axes = plt.subplots(
        len(THREE_FEET), 3, figsize=(9, 9.4), sharex=True, sharey=True, layout="constrained"
    )
    for row, name in zip(axes, THREE_FEET, strict=True):
        pushes, support = read_pushes(DATA, name), SUPPORTS[name]
        predicted = Mapped(support), Smooth(support.size / HERTZ_SIZE)
        slips = [pushes.slips, *(surface.limit(pushes.loads)[1] for surface in predicted)]
        for axis, title, slip in zip(row, ("measured", "three feet", "smooth"), slips, strict=True):
            centres = slip_centres(slip)
            axis.fill(*CORNERS.T, color="0.93")
            axis.plot(*support.positions.T, "^", color="tab:red", markersize=9, label="foot")
            axis.plot(*centres.T, ".", color="tab:blue", label="centre of rotation")
            axis.set_title(f"{title}: {at_a_foot(centres, name)} of {len(centres)} at a foot", fontsize=10)
            axis.set(xlim=(-0.15, 0.2), ylim=(-0.15, 0.2), aspect="equal")
        row[0].set_ylabel(f"{name}\ny [m]")
    for axis in axes[-1]:
        axis.set_xlabel("x [m]")
    axes[0, 0].legend(fontsize=8, loc="upper right")
    figure.savefig(path, dpi=110)
    plt.close(figure)


def at_a_foot(centres: Array, name: str) -> int:
    """How many of the centres (n, 2) are as near to a foot as the measurement can tell."""
    support = SUPPORTS[name]
    distance = np.linalg.norm(centres[:, None] - support.positions, axis=2).min(axis=1)
    return int(np.sum(distance < NEAR * support.size))


if __name__ == "__main__":
    sys.exit(main())
