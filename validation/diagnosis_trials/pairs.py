"""``python -m validation.diagnosis_trials.pairs``: of two look-alikes one is hidden; which is named.

For every ordered pair of effects that show in the same regime one recording is made, with the first hidden.
Right is its name, or a set that holds it; the other named for sure is what must not happen. Where the second
bench has the law it makes the recording, for it shares no code with the model, else the virtual bench.
"""

import json
import sys
import zlib
from collections.abc import Collection, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass
from functools import partial
from itertools import permutations
from multiprocessing import get_context
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.table import Table

from validation.diagnosis_trials import second_bench
from validation.diagnosis_trials.cases import Case, make_recording
from vegrip.cli import run
from vegrip.cli._options import JSON
from vegrip.cli._outputs import FORCE, Outputs
from vegrip.cli._terminal import print_json, printer, progress
from vegrip.errors import UsageError, suggestion
from vegrip.identification.diagnosis import diagnose
from vegrip.identification.recording import Fingertip, Recording
from vegrip.plotting import new_figure, save_figure

REGIMES: Mapping[str, tuple[str, ...]] = {
    "by depth": (
        "exponential_stiffness", "layer_over_core", "second_contact", "series_compliance", "saturation",
    ),
    "first and later presses": ("mullins_softening", "healing_softening", "permanent_set"),
    "in holds": (
        "second_relaxation", "power_law_relaxation", "relaxation_spectrum", "nonseparable_relaxation",
        "poroelastic_drainage",
    ),
    "by speed": (
        "sensor_lag", "sensor_delay", "fast_damping", "rate_stiffening", "displacement_backlash",
    ),
    "at touch": ("adhesion", "jkr_adhesion"),
    "in air": ("force_drift", "approach_tilt", "guide_friction"),
    "at slip": (
        "load_dependent_friction", "rate_dependent_friction", "friction_ageing", "presliding", "wet_contact",
    ),
    "of the circle": ("contact_radius_law", "pressure_profile"),
}  # fmt: skip
"""Effects that show in one regime; those that the benches cannot hide are left out."""

EFFECTS = tuple(dict.fromkeys(name for some in REGIMES.values() for name in some))
PAIRS = tuple(pair for some in REGIMES.values() for pair in permutations(some, 2))
STYLES = {
    "bench": "laboratory",
    "short": "short",
    "use": "use",
}  # of the second bench, and of the virtual one
NOTHING = "nothing named"
KEPT = "pairs that are done stay in the file of -o, and the same command goes on with the others"


@dataclass(frozen=True)
class Said:
    """What was said of one recording with ``hidden`` in it, where ``rival`` shows in the same regime."""

    hidden: str
    rival: str
    style: str
    seed: int
    verdict: str
    named: tuple[str, ...]
    sets: tuple[tuple[str, ...], ...]

    @property
    def key(self) -> str:
        return f"{self.hidden} {self.rival} {self.style} {self.seed}"

    @property
    def is_false(self) -> bool:
        """Whether something is named for sure that is not there, or a set holds nothing that is."""
        return bool({*self.named} - {self.hidden}) or any(self.hidden not in one for one in self.sets)

    @property
    def is_right(self) -> bool:
        is_told = self.hidden in self.named or any(self.hidden in one for one in self.sets)
        return is_told and not self.is_false

    @property
    def shares(self) -> dict[str, float]:
        """How much of the answer each effect has: sets are shared evenly."""
        told = [(name,) for name in self.named] + list(self.sets)
        out: dict[str, float] = {}
        for one in told:
            for name in one:
                out[name] = out.get(name, 0.0) + 1.0 / len(one) / len(told)
        return out or {NOTHING: 1.0}


def recording_of(hidden: str, rival: str, style: str, seed: int) -> Recording:
    """Return the recording of a pair; all else is drawn from the names and the seed."""
    drawn = zlib.crc32(f"{hidden} {rival} {seed}".encode()) % 1_000_000
    if hidden in second_bench.AMOUNTS:
        return of_second_bench((hidden,), style, drawn)
    return make_recording(Case((hidden,), "strong", drawn, style=STYLES[style]))


def of_second_bench(hidden: Sequence[str], style: str, seed: int, size: float = 1.0) -> Recording:
    """Return a recording of the second bench."""
    made = second_bench.make(hidden, style, seed, size)
    columns = dict(made.columns)
    t, episode = columns.pop("t"), columns.pop("episode").astype(np.int64)
    noise = {name: std for name, std in made.noise.items() if name in {*columns, "tangential_force"}}
    name = f"{'+'.join(hidden) or 'nothing'} {style} {seed}"
    return Recording(name, t, episode, columns, Fingertip(made.radius), noise)


def judge(hidden: str, rival: str, style: str, seed: int) -> Said:
    found = diagnose(recording_of(hidden, rival, style, seed), threads=1)
    sets = tuple(tuple(one) for one in found.indistinguishable) if found.verdict == "ambiguous" else ()
    return Said(hidden, rival, style, seed, found.verdict, tuple(found.named), sets)


def matrix_of(every: Collection[Said]) -> tuple[list[str], list[str], np.ndarray]:
    """Return what is hidden, what is said, and the mean share of each in the answers."""
    rows = [name for name in EFFECTS if any(one.hidden == name for one in every)]
    said = {name for one in every for name in one.shares}
    columns = [*rows, *sorted(said - {*rows} - {NOTHING}), NOTHING]
    shares = np.zeros((len(rows), len(columns)))
    for i, name in enumerate(rows):
        mine = [one for one in every if one.hidden == name]
        for one in mine:
            for told, share in one.shares.items():
                shares[i, columns.index(told)] += share / len(mine)
    return rows, columns, shares


def draw(every: Collection[Said], path: Path) -> None:
    """Draw the confusion matrix, with a ring about what was named falsely and for sure."""
    rows, columns, shares = matrix_of(every)
    figure, (axes,) = new_figure(size=(9.5, 8.0))
    axes.imshow(shares, cmap="Blues", vmin=0.0, vmax=1.0, aspect="auto")
    for i, j in np.argwhere(shares > 0.0):
        axes.text(j, i, f"{100 * shares[i, j]:.0f}", ha="center", va="center", fontsize=6,
                  color="white" if shares[i, j] > 0.6 else "black")  # fmt: skip
    for one in every:
        for name in {*one.named} - {one.hidden}:
            axes.plot(columns.index(name), rows.index(one.hidden), "o", ms=15, mfc="none", mec="red")
    axes.set_xticks(range(len(columns)), columns, rotation=90, fontsize=7)
    axes.set_yticks(range(len(rows)), rows, fontsize=7)
    axes.set_xlabel("said [% of the answers]")
    axes.set_ylabel("hidden")
    save_figure(figure, path)


def told(every: Sequence[Said]) -> dict[str, Any]:
    """Return counts, and what was said falsely."""
    return {
        "pairs": len(every),
        "right": sum(one.is_right for one in every),
        "falsely": {one.key: [*one.named, *("|".join(s) for s in one.sets)] for one in every if one.is_false},
        "missed": {one.key: one.verdict for one in every if not one.is_right and not one.is_false},
    }


def trial(
    regime: Annotated[
        list[str] | None, typer.Option("--regime", help="Only of this one; may be repeated.")
    ] = None,
    effect: Annotated[
        list[str] | None, typer.Option("--effect", help="Only with this effect hidden; may be repeated.")
    ] = None,
    style: Annotated[
        list[str] | None, typer.Option("--style", help="bench, short or use, in turn; use when not given.")
    ] = None,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Of all that is drawn.")] = 0,
    jobs: Annotated[int, typer.Option("--jobs", "-j", min=1, help="Recordings at a time.")] = 1,
    picture: Annotated[Path | None, typer.Option("--picture", help="File for the confusion matrix.")] = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="File of results, one per line; not repeated.")
    ] = None,
    force: FORCE = False,
    as_json: JSON = False,
) -> None:
    """Hide one of two effects that resemble each other, for all pairs, and say what was named.

    Example: python -m validation.diagnosis_trials.pairs --regime "at touch"

    All of them, -j 2, take three minutes on two cores.
    """
    for name in regime or ():
        if name not in REGIMES:
            raise UsageError(f"there is no regime {name!r}; {suggestion(name, REGIMES)}")
    for name in effect or ():
        if name not in EFFECTS:
            raise UsageError(f"no effect {name!r} is in these pairs; {suggestion(name, EFFECTS)}")
    for name in style or ():
        if name not in STYLES:
            raise UsageError(f"there is no style {name!r}; {suggestion(name, STYLES)}")
    wanted = [
        pair
        for name, some in REGIMES.items()
        if not regime or name in regime
        for pair in permutations(some, 2)
    ]
    wanted = [pair for pair in wanted if not effect or pair[0] in effect]
    turn = style or ["use"]
    cases = [(*pair, turn[i % len(turn)], seed) for i, pair in enumerate(wanted)]
    with Outputs(force=force) as outputs, progress("pairs") as report:
        outputs.log(output)
        outputs.picture(picture)
        done = _read(output)
        every = [done[key] for case in cases if (key := " ".join(map(str, case))) in done]
        left = [case for case in cases if " ".join(map(str, case)) not in done]
        with ProcessPoolExecutor(jobs, get_context("spawn")) as pool:
            for one in as_completed([pool.submit(judge, *case) for case in left]):
                every.append(one.result())
                outputs.write(output, partial(_append, every[-1]))
                right = sum(each.is_right for each in every)
                report(f"{len(every)} of {len(cases)}, {right} right; {every[-1].key}: {every[-1].verdict}")
        outputs.write(picture, partial(draw, every))
    answer = told(every)
    if as_json:
        print_json(answer)
    else:
        _print(answer, every)


def _read(path: Path | None) -> dict[str, Said]:
    if path is None or not path.exists():
        return {}
    lines = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
    every = [
        Said(**{**one, "named": tuple(one["named"]), "sets": tuple(tuple(s) for s in one["sets"])})
        for one in lines
    ]
    return {one.key: one for one in every}


def _append(one: Said, path: Path) -> None:
    with path.open("a", encoding="utf-8") as stream:
        stream.write(json.dumps(asdict(one)) + "\n")


def _print(answer: dict[str, Any], every: Sequence[Said]) -> None:
    console = printer()
    table = Table(box=None, padding=(0, 2))
    for heading in ("hidden", "pairs", "named", "in a set", "not told", "falsely"):
        table.add_column(heading, justify="left" if heading == "hidden" else "right")
    for name in EFFECTS:
        mine = [one for one in every if one.hidden == name]
        if mine:
            named = sum(one.is_right and name in one.named for one in mine)
            right, false = (sum(getattr(one, kind) for one in mine) for kind in ("is_right", "is_false"))
            row = len(mine), named, right - named, len(mine) - right - false, false
            table.add_row(name, *map(str, row))
    console.print(table)
    console.print(
        f"{answer['right']} of {answer['pairs']} named or in a set, {len(answer['falsely'])} falsely"
    )
    for key, said in answer["falsely"].items():
        console.print(f"  {key} -> {', '.join(said)}")


if __name__ == "__main__":
    sys.exit(run(trial, sys.argv[1:], "python -m validation.diagnosis_trials.pairs", KEPT))
