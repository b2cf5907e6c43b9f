"""The contract of an effect: declared parameters and states, and hooks at named stages of the recursion.

One sample of the contact runs through the stages in this order; a hook takes what it needs **by the names
of its arguments** and gives the new value of one quantity::

    stage      gives             starts as      states change
    tip        x                 delta          yes            indentation [m] after mount and tip
    elastic    elastic_force     -              yes            N_e(x) [N]
    force      force             elastic_force  yes            N [N] with relaxation
    sense      sensed_force      force          yes            what the sensor shows [N]
    area       contact_radius    -              no             a [m]
    profile    exponent          -              no             k [-]
    friction   friction          -              no             mu [-]

A hook that takes the quantity it gives *modifies* it; one that does not *defines* it, and there can be only
one of those. A hook may also give ``relaxation_rate``, ``relaxation_strength`` (factors on all branches,
1), ``adhesion`` [N] (pull that is subtracted after the free-surface line) or a parameter of another effect,
for the hooks that follow in the list; at the stage ``tip`` also ``compliance`` [m/N], by which what carries
the tip gives way, ``x = delta - compliance N``, solved for x within the step. :data:`INPUTS` names what
comes from outside.

A hook is plain scalar Python with only ``math``, numbers and functions of its own file. It returns the
quantity, followed by the new values of those of its effect's states that it takes (in the order in which the
effect declares them); with ``gives=""`` it returns only states. Called with ``dt = 0`` and its own new
states it must return the same again: that is how the online estimator reads the force of its present state.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Final

from vegrip.parameters import Parameter

Function = Callable[..., Any]

STAGES: Final = {
    "tip": "x",
    "elastic": "elastic_force",
    "force": "force",
    "sense": "sensed_force",
    "area": "contact_radius",
    "profile": "exponent",
    "friction": "friction",
}
"""Stage -> the quantity it gives, in the order in which they run."""

READING: Final = ("area", "profile", "friction")
"""The stages that only read states."""

STARTS: Final = {"x": "delta", "force": "elastic_force", "sensed_force": "force"}
"""What a quantity is before its first hook; the others need a hook that defines them."""

FACTORS: Final = {"relaxation_rate": 1.0, "relaxation_strength": 1.0, "adhesion": 0.0, "compliance": 0.0}
"""Quantities that exist without any effect."""

OUTSIDE: Final = (
    "temperature",  # [degrees Celsius]
    "tangential_force",  # [N] magnitude
    "torque",  # [N m] magnitude
    "slip_speed",  # [m/s], 0 while the contact sticks
    "tangential_force_x",  # [N]
    "tangential_force_y",  # [N]
)
"""Measured beside the motion; held when not measured."""

INPUTS: Final = ("delta", "speed", *OUTSIDE)
"""What comes from outside; the first two [m], [m/s]."""

GEOMETRY: Final = ("tip_radius", "reference_depth", "reference_temperature")
"""Constants of the fingertip: R [m], x_ref [m] and the temperature [degrees Celsius] its values hold at."""


@dataclass(frozen=True, slots=True)
class State:
    """A memory of an effect.

    ``low`` and ``high`` name the quantities between which it may lie when the contact is met in the middle,
    with unknown history; without them it is then ``initial``, surely. ``share`` names a parameter that scales
    both. A ``lasting`` state does not recover between trials (wear, set, drift).
    """

    name: str
    unit: str
    doc: str
    initial: float = 0.0
    low: str = ""
    high: str = ""
    share: str = ""
    extreme: bool = False  # a running maximum or the like: measurements must not drag it (see estimator)
    lasting: bool = False


@dataclass(frozen=True, slots=True)
class Hook:
    """A function at a stage. ``source`` replaces its text where Python cannot find it (made by exec)."""

    function: Function
    stage: str
    gives: str
    source: str = ""


@dataclass(frozen=True, slots=True)
class Effect:
    """One physical effect.

    What the search for a missing effect needs to know of it stands here too, after its states.

    Attributes:
        channels: measurements that can show it.
        confounded: effects whose signature resembles its own.
        experiment: the motion that distinguishes them.
        residual: what a model without it leaves, in words.
        generalises: effects that it can be; a diagnosis tries it where one of them leaves more than noise,
            in that one's place, and nowhere else.
        group: effects of one group cannot be separated by force and displacement at all.
        kinked: its derivative where it is absent says little, so a fit is tried on half of the evidence.
        expensive: it slows a model down even where it is absent, so it is screened in a model of its own.
        shifts_time: it moves the force in time; a second such effect corrects the form of the first.
        in_air: it acts without a contact too, so it is not looked for where the drive moves in contact alone.
        companions: effects that are tried where it is tried, and the other way round.
        min_gain: evidence [nats] below which it is not named, where more is asked than of others.
        min_amounts: parameter and amount that sensors resolve at least, in the parameter's unit.
        min_displacement_noises: the same in standard deviations of the displacement over the reference depth.
        beyond_simpler: how many of these parameters have to exceed these values (in their units); with fewer
            it is an effect that has fewer parameters.
        trial_sizes: multiples of the declared amount at which it is tried; several where it is not
            proportional to it.
        trial_shapes: parameter that only shapes it and the values at which it is tried.
        trials_at: gives further trials for the values of a model and the greatest force measured [N].
        friction_over_load: it states how friction depends on the normal force; nothing is assumed of it then.
        imitated_by: fault of a recording that looks the same, as a sentence with the effect's symbols and
            ``radius`` in braces.
        file: where it was read from, of an effect that is in no package.

    """

    name: str
    summary: str
    cites: tuple[str, ...]  # keys of docs/references.bib
    hooks: tuple[Hook, ...]
    parameters: tuple[Parameter, ...] = ()
    states: tuple[State, ...] = ()
    channels: tuple[str, ...] = ("normal_force",)
    confounded: tuple[str, ...] = ()
    experiment: str = ""
    residual: str = ""
    generalises: tuple[str, ...] = ()
    group: str = ""
    kinked: bool = False
    expensive: bool = False
    shifts_time: bool = False
    in_air: bool = False
    companions: tuple[str, ...] = ()
    min_gain: float = 0.0
    min_amounts: tuple[tuple[str, float], ...] = ()
    min_displacement_noises: tuple[tuple[str, float], ...] = ()
    beyond_simpler: tuple[int, tuple[tuple[str, float], ...]] = (0, ())
    trial_sizes: tuple[float, ...] = (1.0,)
    trial_shapes: tuple[tuple[str, tuple[float, ...]], ...] = ()
    trials_at: Callable[[Mapping[str, float], float], Iterator[Mapping[str, float]]] | None = None
    friction_over_load: bool = False
    imitated_by: str = ""
    file: str = ""


def hook(function: Function, *, stage: str = "", gives: str | None = None, source: str = "") -> Hook:
    """Make a hook; by default the stage is the function's name and it gives that stage's quantity."""
    stage = stage or function.__name__
    return Hook(function, stage, STAGES.get(stage, "") if gives is None else gives, source)
