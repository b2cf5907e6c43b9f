"""What the fingers of a grasp share, by section: ``g.trust.proof[i]`` in Python, and a place where compiled.

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
BELIEF_ROW: Final = (
    BELIEF_MOST + 1
)  # numbers of the joint belief: of each finger, and the exponent behind them
LATE_STEPS: Final = 8  # in which the delay of a slip channel is kept

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
    prior_var: float
    shock: float  # std of ln mu of what happens to all faces at once
    mean: Annotated[MutableSequence[float], BELIEF_ROW]  # of ln mu at the reference load, then the exponent
    common: Each  # std of what each shares with all, at the beginning
    load: Each  # relative load of each, ln(N / N_0)
    site: Each  # precision of the evidence of the present loading of each, 0 = there is none
    site_weighted: Each  # that times its mean
    site_load: Each  # relative load of it
    along: Annotated[MutableSequence[float], BELIEF_ROW]  # scratch
    p: Annotated[MutableSequence[float], BELIEF_ROW * BELIEF_ROW]  # covariance, by rows


class Probe:
    """How force is let go of (:mod:`vegrip.grip.friction_probe`)."""

    climb: float  # [1/s] of ln mu while the object is unknown
    rate: float  # [1/s] afterwards
    unknown: float  # std of ln mu above which the object is unknown
    known: float  # and below which a finger is known well enough
    quiet_time: float  # [s] without a change of any load before probing goes on
    quiet_change: float  # relative change of a load that is one
    pause: float  # [s] after a slip
    reach: float  # standard deviations above the mean up to which it is probed
    since_slip: float  # [s]
    shift: Each  # of ln mu, by which a finger counts on more than is believed
    load: Each  # [N] from which changes are counted
    smooth: Each  # [N] load without noise
    still: Each  # [s] since the load last changed; negative: not in contact
    need: Each  # [N] what each finger needs on its own


class Onset:
    """How slip begins (:mod:`vegrip.grip.friction_onset`)."""

    noise: float  # std of ln mu from one onset to the next
    shock: float  # std of ln mu of what befalls all faces at once
    run: Each  # samples of slip in a row; negative: this run does not count, or has taught
    sum: Each  # of ln u in this run
    quiet: Each  # [s] since the last sample of slip
    held: Each  # largest u that was held of late
    doubted: Each  # how often the channel contradicted the load
    silent: Each  # 1 while slip is not sensed


class Drive:
    """The lag of the drives (:mod:`vegrip.grip.drive_lag`)."""

    told: float  # [s] lag of all drives as it is told; 0 = it is not
    is_measured: float  # 1 = the measured lag counts instead, once it is known
    burst: float  # [1/s] relative growth of a load that comes in a burst
    noise: float  # [N] std of a normal force
    lag: Each  # [s] measured behind a need
    known: Each  # 1 = it is known
    begun: Each
    command: Each  # [N] the last one
    model: Each  # [N] x
    play: Each  # [N] the command behind a play, which tells w
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


class Felt:
    """What the slip channels say (:mod:`vegrip.grip.felt_slip`)."""

    sliding: float  # [m/s] slip speed from which a finger slides; 0 = the flag alone tells
    delay: float  # [s] by which what is felt is late
    quiet: Channels  # [s] since the channel last said slip
    began: Channels  # largest u of the burst, 0 = was not known
    low: Channels  # [s] for which it has said slip of late with u far below that
    over: Channels  # [s] for which u has been far below that
    against: Channels  # [s] for which the other channel has said otherwise
    off: Channels  # [s] for which the channel will not be believed
    why: Channels  # the reason for that
    live: Channels  # [s] for which it has been sensed and silent, up to FELT_SILENCE; 0 where not sensed


class Late:
    """The load a delay ago (:mod:`vegrip.grip.late_slip`)."""

    age: Each  # [s] since the last step
    ended: Each  # 1 where the slide that is felt now is over
    past: Annotated[
        MutableSequence[float], LATE_STEPS * BELIEF_MOST
    ]  # u, the newest first, from LATE_STEPS i


class Change:
    """ln mu before it fell (:mod:`vegrip.grip.friction_change`)."""

    level: Each
    spread: Each  # its std


class Trust:
    """Whether felt slip is proven (:mod:`vegrip.grip.slip_trust`)."""

    held: float  # [s] for which the grasp still counts on the prior after the load has shown a slide
    least: float  # least y of late; inf: no finger is let go of
    load: float  # [N] f when y was least
    grip: float  # [N] N when y was least
    fell: float  # [N] by which f had fallen when the load showed a slide
    wait: float  # [s] until that is judged; 0: nothing is to be judged
    missed: float  # slides that no channel told, since the last one that one told
    first: float  # [N] N when force began to be let go of
    later: float  # [N] N that lags
    ratio: float  # f / N that lags
    torn: float  # f / N when the load showed a slide
    exponent: float  # of friction over the load before anything was felt
    exponent_var: float  # its variance
    prior: Each  # mean ln mu before anything was felt, at the reference load
    spread: Each  # its std
    proof: Each  # [s] for which the proof still counts
    top: Each  # largest utilisation of late
    pull: Each  # [N] smoothed tangential force; 0: the finger does not touch
    force: Each  # [N] smoothed normal force
    speed: Each  # [m/s] last slip speed
    constant: Each  # samples for which it has been exactly that
    noisy: Each  # changes of it while nothing slid
    false: Each  # slips of late that it told far below what it had held
    void: Each  # 1 where what it has taught is void, its flag being wrong
    rim: Each  # [s] for which it has slid by its slip speed alone
    kept: Each  # of what it was let go of, what the load has shown to hold
    clean: Each  # the same when no flag had told slip for a while
    mean: Each  # the same at the last sample
    told: Each  # [s] since it told slip where it may have slid


SECTIONS: Final[dict[str, type]] = {
    "belief": Belief, "probe": Probe, "onset": Onset, "drive": Drive, "lead": Lead, "felt": Felt,
    "late": Late, "change": Change, "trust": Trust,
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
    return "\n".join(
        [f"BELIEF_MOST = {BELIEF_MOST}", f"BELIEF_ROW = {BELIEF_ROW}", f"LATE_STEPS = {LATE_STEPS}", *places]
    )


class GraspMemory:
    """The numbers that the fingers of one grasp share.

    Args:
        fingers: of which no need is known yet; they may be more than can share friction.

    """

    belief: Belief
    probe: Probe
    onset: Onset
    drive: Drive
    lead: Lead
    felt: Felt
    late: Late
    change: Change
    trust: Trust

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
