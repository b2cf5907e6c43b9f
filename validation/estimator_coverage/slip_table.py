"""Is the time to slip honest? A table over grips that are held until they slip."""

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from validation.estimator_coverage.slips import LOOKS, SCENARIOS, Forecast, Scenario, forecasts

HEADER = (
    *("hold", "looked after", "load", "looks", "before the bound"),
    *("before a time", "though none", "by the estimate", "though never"),
)


class Row(NamedTuple):
    """One line: shares [-] with the number of looks they are taken of."""

    scenario: str
    look: float  # [s] into the hold
    load: str  # judged by the slip with the load as it went on, or had it stayed
    looks: int
    before_bound: float  # slipped before the earliest bound; honest: at most 0.05
    before_time: float  # the same of the looks where that bound is a time; honest: 0.05
    bounds: int
    though_none: float  # slipped, of the looks where the bound is never; honest: at most 0.05
    by_estimate: float  # slipped by the estimated time, where there was one; honest: 0.5
    estimates: int
    though_never: float  # slipped, where the estimate was never
    nevers: int

    def __str__(self) -> str:
        """Return the line of the table."""
        cells = (
            percent(self.before_bound),
            f"{percent(self.before_time)} ({self.bounds})",
            f"{percent(self.though_none)} ({self.looks - self.bounds})",
            f"{percent(self.by_estimate)} ({self.estimates})",
            f"{percent(self.though_never)} ({self.nevers})",
        )
        start = f"{self.scenario:<17}{self.look:>10.1f} s  {self.load:<14}{self.looks:>7}"
        return start + "".join(cell.rjust(17) for cell in cells)


def table(slips: int, seed: int, branches: int | None = None) -> Iterator[Row]:
    """Yield the rows over ``slips`` slips in every scenario."""
    for scenario in SCENARIOS:
        found = list(forecasts(scenario, slips, seed, branches=branches))
        for number, look in enumerate(LOOKS):
            yield from rows(scenario, look, [forecast for n, forecast in found if n == number])


def rows(scenario: Scenario, look: float, found: Sequence[Forecast]) -> Iterator[Row]:
    """Yield one row; two where the load does not stay as it was."""
    if scenario.growing:
        yield row(scenario.name, look, "had it stayed", found, [f.slip_if_held for f in found])
        yield row(scenario.name, look, "as it grew", found, [f.slip for f in found])
    else:
        yield row(scenario.name, look, "constant", found, [f.slip for f in found])


def row(name: str, look: float, load: str, found: Sequence[Forecast], slips: Sequence[float]) -> Row:
    """Judge the forecasts by when the grips slipped."""
    slip = np.array(slips)
    estimate, earliest = np.array([(f.estimate, f.earliest) for f in found]).reshape(-1, 2).T
    finite, bounded = estimate < math.inf, earliest < math.inf
    return Row(
        name,
        look,
        load,
        len(found),
        share(slip < earliest),
        share((slip < earliest)[bounded]),
        int(bounded.sum()),
        share((slip < math.inf)[~bounded]),
        share((slip <= estimate)[finite]),
        int(finite.sum()),
        share((slip < math.inf)[~finite]),
        int((~finite).sum()),
    )


def share(hits: "np.ndarray[tuple[int], np.dtype[np.bool_]]") -> float:
    """Return the share of true values; NaN of none."""
    return float(np.mean(hits)) if hits.size else math.nan


def percent(value: float) -> str:
    """Return a share in percent, "-" for none."""
    return "-" if math.isnan(value) else f"{100.0 * value:.1f}"


def header() -> str:
    """Return the first line of the table."""
    names = HEADER
    start = f"{names[0]:<17}{names[1]:>12}  {names[2]:<14}{names[3]:>7}"
    return start + "".join(name.rjust(17) for name in names[4:])
