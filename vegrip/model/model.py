"""The contact model: a fingertip and an ordered list of effects. The only place with physics.

:func:`paper_model` is that of the paper; its prior covers silicone fingertips of ordinary hardness.
"""

import ctypes
import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any, ClassVar, Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vegrip.c99 import MEMORY
from vegrip.c99.kinds import INT
from vegrip.contact import limit_surface
from vegrip.displayed import Displayed
from vegrip.effects import Effect, effect, place
from vegrip.effects.contract import GEOMETRY, OUTSIDE
from vegrip.errors import ModelError
from vegrip.model import cache, native, writer
from vegrip.model.composer import Plan, compose, probe
from vegrip.model.native import kernel_mode
from vegrip.parameters import Parameter, Value, changed, check, declared
from vegrip.types import Floats

ENTRIES: Final[native.Entries] = {
    "run": (*[MEMORY] * 6, INT),
    "channels": (*[MEMORY] * 10, INT),
    "depths": (*[MEMORY] * 9, INT),
}
"""The arrays, room for one step, and the number of rows."""


class Batch:
    """The entries that run a recording; see ``simulate_kernel.py`` and ``channels_kernel.py``.

    Arrays are given in their shapes; the kernels take them flat, so that one text serves C too.

    Args:
        effects: of the model.
        plain: run as uncompiled Python (70 times slower), to step through with a debugger.

    """

    def __init__(self, effects: tuple[Effect, ...], *, plain: bool) -> None:
        text = text_of(effects)
        states = sum(len(effect.states) for effect in effects)
        values = sum(len(effect.parameters) for effect in effects)
        self._room = values + len(GEOMETRY) + len(OUTSIDE) + 2 * states
        mode = "python" if plain else native.kernel_mode()
        library = native.library_by(mode, text, ENTRIES)
        self._is_native = library is not None
        if library is None:
            module = cache.load_plain(text) if mode == "python" else cache.load(text)
            self._entries = {name: getattr(module, name) for name in ENTRIES}
            return
        loaded = ctypes.CDLL(str(library))  # lets other threads run: a recording takes longer than a switch
        self._entries = {name: loaded[f"vg_{name}"] for name in ENTRIES}
        for name, kinds in ENTRIES.items():
            entry = self._entries[name]
            entry.argtypes = [ctypes.c_void_p if kind == MEMORY else ctypes.c_int32 for kind in kinds]
            entry.restype = None

    def run(self, values: Floats, states: Floats, t: Floats, inputs: Floats, out: Floats) -> None:
        """Fill ``out`` (n, 7) for ``inputs`` (n, 2 + outside) at ``t``; ``states`` ends as the last ones."""
        self._call("run", values, states, t, inputs, out)

    def channels(self, values: Floats, fresh: Floats, t: Floats, *arrays: Floats) -> None:
        self._call("channels", values, fresh, t, *arrays)

    def depths(self, values: Floats, fresh: Floats, t: Floats, *arrays: Floats) -> None:
        """Put indentations in place of the NaN of the motion."""
        self._call("depths", values, fresh, t, *arrays)

    def _call(self, name: str, *arrays: Floats) -> None:
        given = [*arrays, np.zeros(self._room)]
        for array in given:
            if array.dtype != np.float64 or not array.flags.c_contiguous:
                raise TypeError("arrays of a recording are of doubles, without gaps")
        taken: list[Any] = [a.ctypes.data if self._is_native else a.reshape(-1) for a in given]
        self._entries[name](*taken, arrays[2].size)


@lru_cache(maxsize=64)
def batch_of(effects: tuple[Effect, ...], mode: str, *, plain: bool = False) -> Batch:
    """Return the entries for ``effects``; they do not depend on the values of the parameters."""
    del mode  # the kernel mode, so that another one is another entry of the cache
    return Batch(effects, plain=plain)


def text_of(effects: tuple[Effect, ...]) -> str:
    here = Path(__file__)
    files = [Path(limit_surface.__file__).with_name("fast.py")]
    files += [here.with_name(f"{name}_kernel.py") for name in ("simulate", "channels")]
    kernels = [path.read_text(encoding="utf-8") for path in files]
    return writer.write(compose(effects), [effect.name for effect in effects], kernels, list(ENTRIES))


class Simulation(NamedTuple):
    """A record as the model gives it; arrays of the length of the input."""

    indentation: Floats  # x [m]
    elastic_force: Floats  # [N]
    normal_force: Floats  # N [N]
    sensed_force: Floats  # what the sensor shows [N]
    contact_radius: Floats  # a [m]
    pressure_exponent: Floats  # k
    friction_coefficient: Floats  # mu

    def __repr__(self) -> str:
        deepest, most = (float(np.max(one, initial=0.0)) for one in (self.indentation, self.normal_force))
        rows = np.size(self.indentation)
        return f"<Simulation: {rows} rows, indentation to {deepest:.3g} m, normal force to {most:.3g} N>"


@dataclass(frozen=True)
class Shown:
    """The range over which a model was fitted; beyond it nothing was seen of what it says.

    Not finite where that is not known.
    """

    depth: float = math.inf  # [m] the deepest indentation
    speed: float = math.inf  # [m/s] the quickest motion in contact
    load: float = math.inf  # [N] the largest normal force
    coldest: float = -math.inf  # [degrees Celsius]
    warmest: float = math.inf


@dataclass(frozen=True, repr=False)
class ContactModel(Displayed):
    """One fingertip: geometry, effects in order, values of their parameters.

    Raises:
        ModelError: effects that cannot work together, a value out of bounds, an effect that returns NaN;
            the message names the effect and the remedy.

    """

    _display: ClassVar[str] = "model"

    effects: tuple[Effect, ...]
    values: Mapping[str, Value]  # by symbol; symbols are unique within a model
    tip_radius: float  # R [m]
    reference_depth: float  # x_ref [m], where K is the elastic force
    reference_temperature: float = 23.0  # [degrees Celsius] at which the values hold
    provenance: Mapping[str, str] = field(default_factory=dict)  # recording, date, error, ...
    shown: Shown = Shown()

    def __post_init__(self) -> None:
        for name in ("tip_radius", "reference_depth"):
            if not 0.0 < getattr(self, name) < math.inf:
                raise ModelError(f"{name} is {getattr(self, name)}; give it in metres, positive")
        known = self.parameters
        for symbol in self.values:
            if symbol not in known:
                raise ModelError(
                    f"no effect of the model has a parameter {symbol!r}; there are {', '.join(known)}"
                )
        for symbol, (owner, parameter) in known.items():
            if symbol not in self.values:
                raise ModelError(
                    f"{owner}: the value of {symbol} is missing; the default is {parameter.default:g}"
                )
            check(owner, parameter, self.values[symbol])
        probe(self.effects, self.plan, self.vector, self.reference_depth)

    @cached_property
    def plan(self) -> Plan:
        return _composed(self.effects)

    @property
    def parameters(self) -> dict[str, tuple[str, Parameter]]:
        return {p.symbol: (e.name, p) for e in self.effects for p in e.parameters}

    @property
    def vector(self) -> Floats:
        """Parameter values in order, then geometry: what the compiled functions take."""
        values = [self.values[symbol].value for symbol in self.parameters]
        return np.array([*values, self.tip_radius, self.reference_depth, self.reference_temperature])

    @property
    def initial_states(self) -> Floats:
        return np.array([s.initial for e in self.effects for s in e.states], dtype=np.float64)

    def source(self, kernels: Sequence[str] = (), entries: Sequence[str] = ()) -> str:
        return writer.write(self.plan, [e.name for e in self.effects], kernels, entries)

    def compiled(self, *, plain: bool = False) -> Batch:
        return batch_of(self.effects, kernel_mode(), plain=plain)

    def simulate(
        self,
        t: ArrayLike,
        displacement: ArrayLike,
        *,
        temperature: ArrayLike | None = None,
        tangential_force: ArrayLike = 0.0,
        torque: ArrayLike = 0.0,
        slip_speed: ArrayLike = 0.0,
        tangential_direction: ArrayLike = 0.0,
        states: ArrayLike | None = None,
        plain: bool = False,
    ) -> Simulation:
        """Run a record through the model.

        Args:
            t: instants [s], shape (n,), not decreasing; any spacing.
            displacement: indentation at these instants [m], linear in between as far as its force is.
            temperature: [degrees Celsius]; the reference temperature when not given.
            tangential_force: magnitude [N].
            torque: about the normal, magnitude [N m].
            slip_speed: [m/s], 0 while it sticks.
            tangential_direction: of the tangential force, angle from x [rad].
            states: of the effects at the start; at rest when not given.
            plain: run as uncompiled Python (70 times slower), for debugging.

        """
        t, delta = np.asarray(t, dtype=np.float64), np.asarray(displacement, dtype=np.float64)
        warm = self.reference_temperature if temperature is None else temperature
        speed = np.diff(delta, prepend=delta[:1]) / np.maximum(np.diff(t, prepend=t[:1] - 1.0), 1e-12)
        f, angle = np.asarray(tangential_force, dtype=np.float64), np.asarray(tangential_direction)
        columns = (delta, speed, warm, f, torque, slip_speed, f * np.cos(angle), f * np.sin(angle))
        inputs = np.ascontiguousarray(np.stack(np.broadcast_arrays(*columns), axis=1), dtype=np.float64)
        start = self.initial_states if states is None else np.array(states, dtype=np.float64)
        out = np.empty((t.size, 7))
        self.compiled(plain=plain).run(self.vector, start, t, inputs, out)
        return Simulation(*out.T)

    def with_value(self, symbol: str, value: float, **fields: Any) -> "ContactModel":
        """Return the model with another value (and ``std``, ``low``, ``high``, ``learn``) of a parameter."""
        if symbol not in self.values:
            raise ModelError(f"the model has no parameter {symbol!r}; it has {', '.join(self.values)}")
        new = changed(self.values[symbol], value=float(value), **fields)
        return dataclasses.replace(self, values={**self.values, symbol: new})

    def with_effect(self, effect: Effect) -> "ContactModel":
        """Return the model with one more effect, at its declared values and in its place."""
        values = {**self.values, **{p.symbol: declared(p) for p in effect.parameters}}
        at = place([e.name for e in self.effects], effect.name)
        return dataclasses.replace(
            self, effects=(*self.effects[:at], effect, *self.effects[at:]), values=values
        )


_composed = lru_cache(maxsize=64)(compose)  # a diagnosis makes hundreds of models of few lists

BASE = ("power_law_stiffness", "relaxation", "geometric_radius", "pressure_coupling", "coulomb_friction")
"""Effects of the base model, in order."""


MAX_RADIUS_M = 1.0  # [m]


def paper_model(tip_radius: float, *, modulus: float = 3e5) -> ContactModel:
    """Return the base model of a fingertip of radius ``tip_radius`` [m].

    Args:
        tip_radius: R of the undeformed fingertip [m].
        modulus: a guess of the effective modulus E* [Pa] for the prior of K, Hertz' ``4/3 E* sqrt(R) x^1.5``
            at ``x_ref = R / 10``. Silicone 1e5 .. 1e6, living cells 1e2 .. 1e4. The prior is wide, a factor
            of 1.6.

    Raises:
        ModelError: a radius that no tip has: above 1 m it is millimetres taken for metres.

    """
    if not 0.0 < tip_radius <= MAX_RADIUS_M:
        raise ModelError(
            f"tip_radius is {tip_radius:g} m; give it in metres, above 0 and up to {MAX_RADIUS_M:g}"
        )
    depth = tip_radius / 10.0
    effects = tuple(effect(name) for name in BASE)
    values = {p.symbol: declared(p) for e in effects for p in e.parameters}
    values["K"] = changed(values["K"], value=4.0 / 3.0 * modulus * tip_radius**0.5 * depth**1.5)
    return ContactModel(
        effects, values, tip_radius, depth, provenance={"origin": "prior of the paper's model"}
    )


def material_model(*, is_linear: bool, temperature: float = math.nan) -> ContactModel:
    """Return the base model of a specimen without a contact, whose stiffness and relaxation are unknown.

    Its section is 1 mm^2, so K [N] is a stress in MPa: of a specimen 1 mm long that at a strain of 0.1, of
    a linear material in a unit step, 1 m long, the modulus at once. ``temperature`` [degrees Celsius] is that
    at which the values hold, when known.
    """
    model = dataclasses.replace(
        paper_model(1.0 if is_linear else 1e-3), provenance={"origin": "prior of a material"}
    )
    known = {p.symbol for e in model.effects[:2] for p in e.parameters}
    if is_linear:
        known.discard("p")
        model = dataclasses.replace(model.with_value("p", 1.0), reference_depth=1.0)
    if math.isfinite(temperature):
        model = dataclasses.replace(model, reference_temperature=temperature)
    values = {s: v if s in known else changed(v, std=0.0) for s, v in model.values.items()}
    return dataclasses.replace(model, values=values)
