"""What the fingers of a grasp share, by section: ``g.slip.sound[i]`` in Python, and a place where compiled.

All of it is one array of real numbers, which the steps of all fingers read and write. First stands what each
finger needs [N], ``g[i]`` (:mod:`vegrip.grip.kernels.share`). What is shared of friction follows, in the
order of :data:`SECTIONS`. ln mu is the logarithm of a friction coefficient, and u that at which the present
load would slip.
"""

from array import array
from collections.abc import Iterator, MutableSequence
from typing import Annotated, Any, Final, get_type_hints

import numpy as np

BELIEF_MOST: Final = 20  # fingers
BELIEF_ROW: Final = BELIEF_MOST + 1  # numbers of the joint belief: of each finger, then the exponent

Each = Annotated[MutableSequence[float], BELIEF_MOST]
"""A number of every finger."""
Threes = Annotated[MutableSequence[float], 3 * BELIEF_MOST]
"""Three of every finger, those of finger i from 3 i on."""
Channels = Annotated[MutableSequence[float], 2 * BELIEF_MOST]
"""Of the slip flag of finger i at i, and of its slip speed at ``BELIEF_MOST`` + i."""


class Belief:
    """Of ln mu and its exponent over the load, as one joint Gaussian (:mod:`vegrip.grip.friction_belief`)."""

    fingers: float
    version: float  # changes with every evidence
    since: float  # [s] since the belief was last widened
    drift: float  # [1/sqrt(s)] random walk of ln mu
    prior_var: float  # of ln mu at the reference load, before anything was felt
    exponent_var: float  # of the exponent, at that time
    lasted: float  # [s] for which fingers have touched
    usual: float  # mean of ln mu at the reference load over that time and all fingers
    usual_square: float  # of its square
    mean: Annotated[MutableSequence[float], BELIEF_ROW]  # of ln mu at the reference load, then the exponent
    common: Each  # std of what each shares with all, at the beginning
    load: Each  # relative load of each, ln(N / N_0)
    record: Each  # largest ln u that each has held since it slid, at the reference load
    site: Each  # precision of what that says, 0 = nothing
    site_weighted: Each  # that times its mean
    site_load: Each  # relative load of it
    doubted: Each  # 1 = what the last slide of each has said may be a lie
    safe_mean: Annotated[MutableSequence[float], BELIEF_ROW]  # the belief before the first slide in doubt
    safe_p: Annotated[MutableSequence[float], BELIEF_ROW * BELIEF_ROW]
    safe_record: Each
    safe_site: Each
    safe_weighted: Each
    safe_load: Each
    along: Annotated[MutableSequence[float], BELIEF_ROW]  # scratch
    p: Annotated[MutableSequence[float], BELIEF_ROW * BELIEF_ROW]  # covariance, by rows


class Drive:
    """The lag of the drives (:mod:`vegrip.grip.drive_lag`)."""

    stated: float  # [s] lag of all drives until it is measured
    burst: float  # [1/s] relative growth of a load that comes in a burst
    noise: float  # [N] std of a normal force
    lag: Each  # [s] measured behind a need
    known: Each  # 1 = it is known
    begun: Each
    command: Each  # [N] the last one
    model: Each  # [N] x
    play: Each  # [N] the command behind a play, which shows w
    wait: Each  # [s] until samples count again
    moved: Each  # [N] by which the command has moved where samples counted
    misfit: Each  # [N] mean innovation of late, without its sign
    force: Each  # [N] the last one
    slope: Each  # [N/s] smoothed rate of the force
    seen: Each  # [N/s] fastest rate with which the drive was seen to follow
    state: Threes  # L [s], s [N], b [N]
    p: Annotated[MutableSequence[float], 9 * BELIEF_MOST]  # their covariance, from 9 i on


class Lead:
    """The load ahead by the lag (:mod:`vegrip.grip.load_lead`): x, y [N] and torque [N m]."""

    noise: float  # [N] std of a tangential force
    torque_noise: float  # [N m]
    begun: Each
    ahead: Threes
    fast: Threes
    slow: Threes


class Slip:
    """What the slip channels say, and whether a finger slides (:mod:`vegrip.grip.slip_channels`)."""

    sliding: float  # [m/s] slip speed from which a finger slides; 0 = the flag alone shows it
    delay: float  # [s] by which what is felt is late
    exponent: float  # by which the utilisations below are referred to the reference load
    sound: Channels  # probability to be sound
    silent: Channels  # probability to be silent
    says: Channels  # 1, 0; NaN = not sensed
    silence: Channels  # [s] since it last said slip
    rate: Channels  # how often it begins to say slip, per look
    odds: Channels  # of the present report by a sound one in a slide against one by a faulty one
    shows: Channels  # what it adds to the logit of a slide
    level: Each  # ln u at the reference load, without noise; -inf: not known
    spread: Each  # std of the utilisation, averaged as it is
    shown: Each  # what is shown to hold: the same, rising no faster than force is lowered
    held: Each  # largest of it of late without a slide
    begun: Each  # what it was when, after a pause, some channel said slip
    top: Each  # largest of the last delay
    top_next: Each
    likely: Each  # chance of a slide by the load alone, largest of the last delay
    likely_next: Each
    likely_age: Each  # [s]
    slides: Each  # probability that the finger slides
    taught: Each  # 1 where the present slide has taught
    teacher: Each  # channel that reported the last slide that taught
    stays: Each  # how far the utilisation is still what it was, largest of the last delay
    stays_next: Each


class Witness:
    """What the load shows of a slide (:mod:`vegrip.grip.slip_witness`)."""

    noise: float  # [N] std of a tangential force
    least: float  # least y of late; inf: no force is lowered
    pull: float  # [N] T then
    force: float  # [N] N when y was least
    lack: float  # of ln T, by which it is less than then while a slide is judged
    lost: float  # [N] by which T had fallen when the slide was seen
    chance: float  # probability that it was one
    waits: float  # [s] until it is judged; 0: nothing is to be judged
    rested: float  # [s] since it was seen
    first: float  # [N] N when lowering began
    lagging: float  # [N] N that lags
    low: float  # [N] least T since
    high: float  # [N] largest T since that
    part: Each  # least y of each finger since force began to be lowered; inf: none is
    slid: Each  # 1 = it has slid since, by its own y
    forces: Each  # [N] smoothed normal force; 0: the finger does not touch
    pulls: Each  # [N] smoothed tangential force


class Release:
    """What is assumed, and how force is lowered (:mod:`vegrip.grip.force_release`)."""

    releases: float  # 1 = force is lowered at all
    risk: float  # of a slide that is not noticed
    kappa: float  # loss of a slide that is noticed over that of one that is not
    pause: float  # [s] until force may be lowered again
    ends: float  # [s] in which a slide that lowering caused ends
    shift: Each  # of ln mu, by which a finger assumes more
    counted: Each  # ln mu at the present load that is assumed
    steady: Each  # [N] load from which changes are counted
    smooth: Each  # [N] load without noise
    still: Each  # [s] since the load last changed; negative: not in contact


class Balance:
    """What the fingers press against the thumb (:mod:`vegrip.grip.kernels.share`)."""

    pressed: Each  # [N] that each was commanded last; 0: nothing


SECTIONS: Final[dict[str, type]] = {
    "belief": Belief, "drive": Drive, "lead": Lead, "slip": Slip, "witness": Witness, "release": Release,
    "balance": Balance,
}  # fmt: skip


def _places() -> Iterator[tuple[str, str, int, int]]:
    """Yield section, name, place and length (0: a single number) of all that is shared of friction."""
    at = BELIEF_MOST
    for section, declared in SECTIONS.items():
        for name, kind in get_type_hints(declared, include_extras=True).items():
            length = kind.__metadata__[0] if hasattr(kind, "__metadata__") else 0
            yield section, name, at, length
            at += length or 1


PLACES: Final = tuple(_places())
SIZE: Final = PLACES[-1][2] + PLACES[-1][3]


def constants() -> str:
    """Return the places as program text."""
    places = [f"{section}_{name}".upper() + f" = {at}" for section, name, at, _ in PLACES]
    return "\n".join([f"BELIEF_MOST = {BELIEF_MOST}", f"BELIEF_ROW = {BELIEF_ROW}", *places])


class GraspMemory:
    """The numbers that the fingers of one grasp share.

    Args:
        fingers: of which no need is known yet; they may be more than can share friction.

    """

    belief: Belief
    drive: Drive
    lead: Lead
    slip: Slip
    witness: Witness
    release: Release
    balance: Balance

    def __init__(self, fingers: int = 0) -> None:
        numbers = array("d", bytes(8 * max(SIZE, fingers)))
        self.array = np.frombuffer(numbers)
        """The same numbers, for the steps."""
        self.array[:fingers] = np.nan
        self._numbers: Any = memoryview(numbers)
        for section, view in _VIEWS.items():
            setattr(self, section, view(self._numbers))

    def __getitem__(self, finger: int) -> float:
        return float(self._numbers[finger])

    def __setitem__(self, finger: int, need: float) -> None:
        self._numbers[finger] = need


class _View:
    """A section of an array that lies elsewhere."""

    def __init__(self, numbers: Any) -> None:
        self.numbers = numbers


def _view(section: str) -> type[_View]:
    here = [(name, at, length) for of, name, at, length in PLACES if of == section]
    return type(section, (_View,), {name: _number(at, length) for name, at, length in here})


def _number(at: int, length: int) -> property:
    if length:
        return property(lambda view: view.numbers[at : at + length])

    def write(view: _View, value: float) -> None:
        view.numbers[at] = value

    return property(lambda view: view.numbers[at], write)


_VIEWS: Final = {section: _view(section) for section in SECTIONS}
