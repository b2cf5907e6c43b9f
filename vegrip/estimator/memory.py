"""The memory of one finger: where everything lies in its two arrays, by name.

Real numbers begin with those of the filter (:mod:`vegrip.estimator.layout`), then comes what the clock of
the samples needs; a finger that grips has more behind both (:mod:`vegrip.grip.layout`). The generated module
gets the places as constants, ``SAMPLE_SEQ`` for SEQ of the section SAMPLE and ``HISTORY0`` for the beginning
of the section HISTORY. Times are in seconds where they are real numbers, if nothing else is said, and in
nanoseconds where they are whole.
"""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vegrip.estimator.layout import Layout

CHANNELS = (
    "normal_force", "tangential_force_x", "tangential_force_y", "torque_z", "displacement", "temperature",
    "slip", "slip_speed", "contact_radius",
)  # fmt: skip
"""The measured quantities of a state, in the order of FingertipState."""

SLIPS = 1.0
"""Value of the slip channel of a contact that slides; between 0 and this it says nothing."""
LEAST_SLIP_SPEED = 2e-4
"""Of a sliding contact [m/s]; a slower one contradicts the slip channel."""

Sections = Mapping[str, tuple[str, ...] | type | int]
"""Name of a section -> names of its numbers, a class that declares them, or how many there are."""


class Taken:
    """Of the last sample that was taken."""

    load: float  # [N] tangential force; NaN: not measured
    torque: float  # [N m]
    slip: float
    bound: float  # of the margin, when a grip asked for it last


class News:
    """The present state."""

    seq: int
    stamp: int  # [ns]


class Clock:
    """Settings of the clock of the samples."""

    recovery: int  # refusals in a row after which the sender's clock has started anew
    gap: int  # [ns] that counts as passed then


class Sample:
    """What the clock knows."""

    begun: int  # whether a sample was taken
    stamp: int  # [ns] of the last one that was taken
    informed: int  # [ns] of the last one that said something about the contact
    is_informed: int  # whether there was one
    shown: int  # [ns] of the last one, taken or not
    trusted: int  # whether that was taken
    seq: int  # samples taken
    resumed: int  # whether the memory is one that was kept, so that an unknown time has passed
    refused: int  # samples whose stamp did not advance
    backwards: int  # of them in a row
    rewind_next: int  # slot of the next sample that is kept
    kept: int  # samples it can go back
    late: int  # samples that were put in their place
    followed: int  # how often the sender's clock had started anew
    offered: int  # samples, taken or not


REALS: Sections = {"STATE": tuple(name.upper() for name in CHANNELS), "TAKEN": Taken}
WHOLES: Sections = {"NEWS": News, "CLOCK": Clock, "SAMPLE": Sample}


@dataclass(frozen=True)
class SampleLayout:
    """Sizes and places for an estimator and the clock of its samples.

    Args:
        filter: of the filter's numbers.
        late: samples that the estimator can go back.

    """

    filter: Layout
    late: int = 0

    def real_sections(self) -> Iterator[tuple[str, tuple[str, ...], int]]:
        """Yield name, names within and length of the sections of real numbers."""
        yield "ESTIMATOR", (), self.filter.size
        yield from named_sections(REALS)
        yield "REWIND", (), self.late * self.filter.lasting
        yield "REWIND_STATE", (), self.late * len(CHANNELS)
        yield "LATER", (), 2 * len(CHANNELS) if self.late else 0

    def whole_sections(self) -> Iterator[tuple[str, tuple[str, ...], int]]:
        yield from named_sections(WHOLES)
        yield from ((f"REWIND_{name}", (), self.late) for name in ("STAMP", "BEFORE", "BEGUN"))

    @cached_property
    def sections(self) -> dict[str, tuple[int, int]]:
        """Name -> beginning and end of each section, in its array."""
        found = {}
        for table in (self.real_sections(), self.whole_sections()):
            start = 0
            for name, _, length in table:
                found[name] = (start, start + length)
                start += length
        return found

    @cached_property
    def reals(self) -> dict[str, int]:
        return dict(_places(self.real_sections()))

    @cached_property
    def wholes(self) -> dict[str, int]:
        return dict(_places(self.whole_sections()))

    @property
    def n_reals(self) -> int:
        return sum(length for _, _, length in self.real_sections())

    @property
    def n_wholes(self) -> int:
        return sum(length for _, _, length in self.whole_sections())

    def constants(self) -> str:
        """Return the places, and what else the clock knows, as program text."""
        return "\n".join([
            *(f"{name} = {place}" for name, place in [*self.reals.items(), *self.wholes.items()]),
            f"MEASURED = {len(CHANNELS)}",
            f"SLIDES = {SLIPS!r}",
            f"LEAST_SLIDING_SPEED = {LEAST_SLIP_SPEED!r}",
            f"MU_LEARNED = {self.filter.mu_learned}",
            f"LATE_SAMPLES = {self.late}",
            f"LASTING_SIZE = {self.filter.lasting}",
        ])  # fmt: skip


class FingerMemory:
    """Real numbers ``f``, whole numbers ``t``, and every one of them by its name."""

    def __init__(self, layout: SampleLayout) -> None:
        self.layout = layout
        self.f = np.zeros(layout.n_reals)
        self.t = np.zeros(layout.n_wholes, dtype=np.int64)
        self._of_filter = layout.filter.places()
        of_filter = {name: (self.f, place) for name, place in layout.filter.named_places()}
        self._places: dict[str, tuple[NDArray[Any], int]] = {
            **of_filter,
            **{name: (self.f, place) for name, place in layout.reals.items()},
            **{name: (self.t, place) for name, place in layout.wholes.items()},
        }

    def __getitem__(self, name: str) -> Any:
        array, place = self._places[name]
        return array.item(place)

    def __setitem__(self, name: str, value: float) -> None:
        array, place = self._places[name]
        array[place] = value

    def take_over(self, other: "FingerMemory", but: Collection[str]) -> None:
        """Take all sections from another memory, but for those named."""
        for name, (start, end) in other.layout.sections.items():
            if name not in but and name in self.layout.sections and end > start:
                self.section(name)[:] = other.section(name)

    def section(self, name: str) -> NDArray[Any]:
        """Return the numbers of a section, also one of the filter, to read and to write."""
        if name in self._of_filter:
            start, end = self._of_filter[name]
            return self.f[start:end]
        start, end = self.layout.sections[name]
        return self._places[f"{name}0"][0][start:end]


def named_sections(table: Sections) -> Iterator[tuple[str, tuple[str, ...], int]]:
    """Yield name, names within and length of each section of a table."""
    for name, content in table.items():
        if isinstance(content, int):
            yield name, (), content
        else:
            names = content.__annotations__ if isinstance(content, type) else content
            yield name, tuple(map(str.upper, names)), len(names)


def _places(sections: Iterator[tuple[str, tuple[str, ...], int]]) -> Iterator[tuple[str, int]]:
    at = 0
    for section, names, length in sections:
        yield f"{section}0", at
        yield from ((f"{section}_{name}", at + i) for i, name in enumerate(names))
        at += length
