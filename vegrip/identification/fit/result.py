"""The result of a fit: the model, how well each value is known, what is left, and what to be wary of."""

import datetime
import importlib
import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc, ndtri

from vegrip.displayed import Result
from vegrip.effects.contract import Effect
from vegrip.errors import KindError
from vegrip.identification.fit.excerpt import EXCERPT
from vegrip.identification.fit.obeys import broken_by
from vegrip.identification.fit.problem import AT, Problem, is_own_name
from vegrip.identification.fit.solve import Optimum, covariance
from vegrip.identification.recording import Recording
from vegrip.identification.recording.checks import AIRLESS, suspect_columns
from vegrip.model import ContactModel, Shown
from vegrip.parameters import SCALES, Parameter, absolute, changed, in_si
from vegrip.types import Floats

LAGS = 20  # of the test for whiteness


@dataclass(frozen=True)
class ChannelError:
    """The error of one channel."""

    rmse: float  # of the residual, in the unit of the channel
    noise: float  # rms of what its noise (and that of the displacement) leaves of a perfect model, same unit
    ratio: float  # rms of the standardised residual; 1 is the noise
    whiteness_p: float  # probability of so much correlation between neighbours by chance (Ljung-Box, 20 lags)
    coverage95: float  # share of residuals within 1.96 standard deviations
    rows: int  # how many


def overall_error(problem: Problem, u: Floats) -> float:
    """Return the rms of the whitened residuals over all channels; 1 is the noise."""
    return rms(problem.residual(u)[problem.counted])


def channel_errors(problem: Problem, u: Floats) -> dict[str, ChannelError]:
    """Return the errors by channel, of those that were measured."""
    table = problem.table(u)
    raw = problem.raw(table)
    white = problem.white(raw)
    m = problem.measured
    n, k = len(m.recording), m.sliding.size
    used, touching = problem.used, problem.stiffness > 0.0
    episode = problem.episodes
    out = {"normal_force": _error(raw[0], problem.force_std, white[:n], used, episode)}
    if np.count_nonzero(used & touching) > 10:
        # the same residual, read along the other axis: the displacement that would have given the force
        stiffness = np.where(touching, problem.stiffness, 1.0)
        firm = used & touching & (problem.stiffness > 0.1 * problem.stiffness.max())
        out["displacement"] = _error(
            -raw[0] / stiffness, problem.force_std / stiffness, white[:n], firm, episode
        )
    for name, size, rows in loads_at_slip(problem, table):
        z = white[n : n + k]
        out[name] = _error(raw[1] * size, problem.slip_std * size, z, rows, episode[m.sliding])
    if m.seen.size:
        everything = np.isfinite(problem.radius_std)
        out["contact_radius"] = _error(
            raw[2], problem.radius_std, white[n + k :], everything, episode[m.seen]
        )
    return out


def loads_at_slip(problem: Problem, table: Floats) -> Iterator[tuple[str, Floats, NDArray[np.bool_]]]:
    """Yield pull [N] and torque [N m] of the rows that slide (k,), and where each is most of the load.

    ``table``: the prediction of ``problem``.
    """
    rows = problem.measured.sliding
    pull, turn = (np.abs(table[rows, AT[name]]) for name in ("tangential_force", "torque_z"))
    force, torque = (np.maximum(table[rows, AT[name]], 0.0) for name in ("limit_force", "limit_torque"))
    pulled, sure = pull * torque >= turn * force, np.isfinite(problem.slip_std)
    for name, size, which in (("tangential_force", pull, pulled), ("torque_z", turn, ~pulled)):
        if (which & sure).any():
            yield name, size, which & sure


def _error(raw: Floats, std: Floats, white: Floats, rows: np.ndarray, episode: np.ndarray) -> ChannelError:
    raw, std, white = raw[rows], std[rows], white[rows]
    z = raw / std
    return ChannelError(
        rms(raw),
        rms(std),
        rms(z),
        whiteness(white, episode[rows]),
        float(np.mean(np.abs(z) < ndtri(0.975))),
        raw.size,
    )


def rms(values: Floats) -> float:
    """Return the root mean square; NaN of nothing."""
    return math.sqrt(float(np.mean(values**2))) if values.size else math.nan


def whiteness(values: Floats, episode: np.ndarray, lags: int = LAGS) -> float:
    """Return the p-value of [LjungBox1978]_ over pairs within the same episode."""
    n = values.size
    power = float(values @ values)
    if n <= 3 * lags or power == 0.0:
        return math.nan
    Q = 0.0
    for lag in range(1, lags + 1):
        same = episode[lag:] == episode[:-lag]
        r = float(np.sum((values[lag:] * values[:-lag])[same])) / power
        Q += n * (n + 2.0) * r * r / max(int(np.count_nonzero(same)), 1)
    return float(chdtrc(lags, Q))


def shown_by(problem: Problem, u: Floats) -> Shown:
    """Return the range of what is touched in a recording."""
    m, table, t = problem.measured, problem.table(u), problem.measured.recording.t
    rows = (problem.stiffness > 0.0) & problem.used
    if not rows.any():
        return Shown()
    speed = np.abs(np.gradient(m.motion.displacement, t))
    _, zeros = problem.parts(u)
    known = {
        "depth": float(np.max(table[rows, AT["indentation"]])),
        "speed": float(np.quantile(speed[rows], NEARLY_ALL)),
        "load": float(np.max((table[:, AT["normal_force"]] - zeros[1])[rows])),
    }
    warm = m.recording.columns.get("temperature", np.zeros(0))
    warm = warm[np.isfinite(warm)]
    if warm.size:
        low, high = float(np.min(warm)), float(np.max(warm))
        known |= {"coldest": low - AS_WARM_K, "warmest": high + AS_WARM_K}
    return Shown(**known)


NEARLY_ALL = 0.999  # of the rows: the quickest are noise
AS_WARM_K = 1.0  # [K] by which a temperature may differ and be the same
UNDETERMINED_SHARE = 0.7  # a posterior std above this share of the prior's: the data say nothing
ENTANGLED = 0.98  # a correlation above this: only a combination is known
AT_BOUND = 1e-3  # of the range, or of a prior std
HOPELESS = 10.0  # and from which it says little to count in units of the noise
GROSS = 0.1  # of the peak force: more than effects of the catalogue make
GENEROUS = 0.5  # and below which the noise cannot be that of the sensors
MISFIT = 1.1  # rms of whitened residuals from which the model is said to fail


@dataclass(frozen=True, eq=False, repr=False)
class Fit(Result):
    """A fitted model and how it was found.

    Attributes:
        model: with the fitted values and their standard errors; runs in the node as it is.
        recording: that was fitted.
        error: rms of the whitened residuals over all channels; 1 is the noise.
        channels: error by channel, in its unit and over its noise.
        std: standard error by name of the unknown; of one with the scale ``log`` that of its logarithm.
        zeros: of the sensors, displacement [m] and normal force [N].
        warnings(): what to know before believing the values.
        problem: model and recording as they were fitted.
        optimum: where it is at its best.
        covariance: (n, n) of the unknowns there.

    """

    _display: ClassVar[str] = "fit"
    _calls: ClassVar[tuple[str, ...]] = ("add", *Result._calls)

    problem: Problem
    optimum: Optimum
    covariance: Floats

    def add(self, *effects: str) -> "Fit":
        """Put ``effects`` into the model, one after the other, and fit again; return that fit.

        Raises:
            ModelError: there is no such effect, or it does not go with the model.
            UsageError: the model has it, or the recording cannot show it.

        """
        # stands below this folder, and knows which effects a recording can show
        ladder: Any = importlib.import_module("vegrip.identification.diagnosis.error_ladder")
        found = self
        for name in effects:
            if not isinstance(name, str):
                raise KindError(f"add wants names of effects, such as 'adhesion', and was given {name!r}")
            found = ladder.add_effect(name, found)[0]
        return found

    @property
    def recording(self) -> Recording:
        return self.problem.measured.recording

    @property
    def std(self) -> dict[str, float]:
        values = np.sqrt(np.maximum(np.diag(self.covariance), 0.0))
        return dict(zip(self.problem.unknowns.names, values.tolist(), strict=True))

    @property
    def model(self) -> ContactModel:
        """The model with fitted values, their standard errors, and where they come from."""
        problem, k = self.problem, self.problem.unknowns
        vector, values = self._vector, dict(problem.model.values)
        for name, place in zip(k.names, k.place.tolist(), strict=True):
            if place >= 0:
                known = values[name]
                inside = min(max(float(vector[place]), known.low), known.high)
                values[name] = changed(known, value=inside, std=self.std[name])
        recording = problem.measured.recording
        provenance = {
            **problem.model.provenance,
            "origin": "fit",
            "recording": recording.name,
            "date": datetime.date.today().isoformat(),
            "error": f"{self.error:.4g} (rms of whitened residuals; 1 is noise)",
        }
        return replace(problem.model, values=values, provenance=provenance, shown=self.shown)

    @property
    def _vector(self) -> Floats:
        """The values of the model; of what each place has for itself, those expected of a further place."""
        vector, _ = self.problem.parts(self.optimum.u)
        for symbol in self.laws[0] if self.laws else ():
            values = np.array([law[symbol] for law in self.laws])
            is_scale = self.problem.model.parameters[symbol][1].transform == "log"
            vector[self.problem.at(symbol)] = np.exp(np.mean(np.log(values))) if is_scale else np.mean(values)
        return vector

    @property
    def shown(self) -> Shown:
        return shown_by(self.problem, self.optimum.u)

    @cached_property
    def broken_laws(self) -> list[str]:
        """Sentences for what the model does within that range and no contact can."""
        return list(broken_by(self.model, self.problem))

    @property
    def zeros(self) -> dict[str, float]:
        """Zeros of the sensors: displacement [m], normal force [N]; the mean where there are several."""
        _, (depth, force) = self.problem.parts(self.optimum.u)
        return {"displacement": float(np.mean(depth)), "normal_force": float(np.mean(force))}

    @property
    def laws(self) -> list[dict[str, float]]:
        """Values of each place, where places have laws of their own; those of the model are between them."""
        problem, u = self.problem, self.optimum.u
        return [
            {s: float(own[problem.at(s)]) for s in problem.own_symbols if s in problem.symbols}
            for own in problem.own_laws(problem.parts(u)[0], u)
            if problem.places.any()
        ]

    @property
    def laws_note(self) -> str:
        """Which laws the places have; empty where they have one."""
        if not self.laws:
            return ""
        K, p = ([law[symbol] for law in self.laws if symbol in law] for symbol in ("K", "p"))
        result = ", ".join(
            f"{name} {min(of):.3g} to {max(of):.3g}{unit}"
            for name, of, unit in (("K", K, " N"), ("p", p, ""))
            if of
        )
        return (
            f"each of {len(self.laws)} episodes has a stiffness of its own ({result}): "
            "other places or specimens were pressed, or something changed between them"
        )

    @property
    def zeros_note(self) -> str:
        """How far the zeros of the episodes differ; empty where the recording has one."""
        if self.problem.zeros == "recording":
            return ""
        _, (depth, force) = self.problem.parts(self.optimum.u)
        return (
            f"each of {int(self.problem.episodes.max()) + 1} episodes has zeros of its own (displacement "
            f"{1e6 * np.min(depth):.3g} to {1e6 * np.max(depth):.3g} um, normal force "
            f"{1e3 * np.min(force):.3g} to {1e3 * np.max(force):.3g} mN), and the errors here are those with "
            "them; the other commands count so with --zeros-each-episode"
        )

    @property
    def channels(self) -> dict[str, ChannelError]:
        return channel_errors(self.problem, self.optimum.u)

    @property
    def error(self) -> float:
        """Rms of the whitened residuals over all channels; 1 is the noise."""
        return overall_error(self.problem, self.optimum.u)

    def declared(self, name: str) -> tuple[Effect, Parameter] | None:
        """Return effect and declaration of an unknown; None for a zero."""
        for effect in self.problem.model.effects:
            for parameter in effect.parameters:
                if parameter.symbol == name:
                    return effect, parameter
        return None

    def in_si(self, name: str) -> tuple[float, str] | None:
        """Return the value of a scaled parameter in SI with its unit; None where it is not scaled."""
        found, values = self.declared(name), self.model.values
        if found is None or "K" not in values:
            return None
        return in_si(found[1], values[name].value, values["K"].value, self.model.reference_depth)

    def _std_in_si(self, parameter: Parameter, value: float) -> float:
        """Return the standard error of ``value`` in SI, of which that of K is a part."""
        names, slope = self.problem.unknowns.names, np.zeros(len(self.covariance))
        _, of_K, of_x = SCALES[parameter.of]
        slope[names.index(parameter.symbol)] = absolute(parameter, value, 1.0)
        if "K" in names:
            slope[names.index("K")] = of_K * value
        scale = self.model.values["K"].value ** of_K * self.model.reference_depth**of_x
        return float(scale * np.sqrt(slope @ self.covariance @ slope))

    def correlations(self, least: float = 0.9) -> list[tuple[str, str, float]]:
        """Return pairs of unknowns that correlate by ``least`` or more, strongest first."""
        s = np.sqrt(np.maximum(np.diag(self.covariance), 1e-300))
        C = self.covariance / np.outer(s, s)
        names = self.problem.unknowns.names
        found = [
            (names[i], names[j], float(C[i, j]))
            for i in range(len(s))
            for j in range(i)
            if abs(C[i, j]) >= least
        ]
        return sorted(found, key=lambda pair: -abs(pair[2]))

    def warnings(self, *, advise: bool = True) -> list[str]:
        """Return what a reader must know before believing the values; ``advise``: and what to run next."""
        return list(_warnings(self, advise=advise))

    def as_dict(self) -> dict[str, Any]:
        """Return what ``--json`` prints; ``std`` there is in the unit of its value, whatever the scale."""
        vector, k = self._vector, self.problem.unknowns
        result: dict[str, Any] = {}
        for name, place in zip(k.names, k.place.tolist(), strict=True):
            found = self.declared(name)
            if place >= 0 and found is not None:
                value = float(vector[place])
                result[name] = {
                    "effect": found[0].name,
                    "value": value,
                    "std": absolute(found[1], value, self.std[name]),
                    "scale": found[1].transform,
                    "unit": found[1].unit,
                }
                if (si := self.in_si(name)) is not None:
                    std = self._std_in_si(found[1], value)
                    result[name]["si"] = {"value": si[0], "std": std, "unit": si[1]}
        noise = self.problem.measured.noise
        return {
            "recording": self.problem.measured.recording.name,
            "parameters": result,
            "zeros": self.zeros,
            "laws": self.laws,
            "correlations": [list(pair) for pair in self.correlations()],
            "channels": {name: asdict(error) for name, error in self.channels.items()},
            "error": self.error,
            "noise": {
                "source": dict(noise.source),
                "normal_force": noise.normal_force,
                "displacement": noise.displacement,
                "slow_force": noise.slow_force,
                "slow_time": noise.slow_time,
                "tolerance": noise.tolerance,
            },
            "outliers": self.problem.measured.outliers,
            "warnings": self.warnings(),
        }


def fit_of(problem: Problem, optimum: Optimum) -> Fit:
    return Fit(problem, optimum, covariance(problem, optimum))


def _warnings(fit: Fit, *, advise: bool) -> Iterator[str]:
    yield from _about_data(fit)
    if not fit.problem.measured.recording.is_step:
        yield from _missing(fit)
        yield from _airless(fit)
    for j, name in enumerate(fit.problem.unknowns.names):
        yield from _about_unknown(fit, j, name)
    for one, other, c in fit.correlations(ENTANGLED):
        if not is_own_name(one) and not is_own_name(other):
            yield f"{one} and {other} are known only together (correlation {c:+.3f})"
    yield from _about_misfit(fit, advise=advise)
    for sentence in fit.broken_laws:
        yield f"the model does what no contact can: {sentence}"


def _about_data(fit: Fit) -> Iterator[str]:
    measured = fit.problem.measured
    if EXCERPT in measured.recording.source:
        yield str(measured.recording.source[EXCERPT])
    yield from measured.noise.doubts
    for channel, count in measured.outliers.items():
        yield f"{count} single outlier(s) of {channel} were left out"
    force = measured.recording.columns["normal_force"]
    for event in measured.events:
        count = int(np.count_nonzero(np.isfinite(force[event.rows])))
        yield (
            f"at {event.time:.4g} s the force falls by {event.loss:.3g} N and no motion explains it (a slip, "
            f"a tear?); {count} rows until it has recovered were left out"
        )


def _about_unknown(fit: Fit, j: int, name: str) -> Iterator[str]:
    k = fit.problem.unknowns
    found = fit.declared(name)
    if found is None:
        if abs(fit.optimum.u[j]) > (1.0 - AT_BOUND) * k.high[j] and name.startswith("zero_"):
            zero = "displacement=contact" if name.startswith("zero_displacement") else "normal_force=baseline"
            yield f"{name} is on its bound: import with --zero {zero} --baseline SECONDS, or check the radius"
        return
    effect, parameter = found
    described = f"{name} ({effect.name})"
    if fit.std[name] > UNDETERMINED_SHARE * k.std[j]:
        yield f"{described} is not determined by this recording; it keeps its prior value"
        return
    span = min(k.std[j], k.high[j] - k.low[j])
    for bound, side in ((k.low[j], "lower"), (k.high[j], "upper")):
        if not (math.isfinite(bound) and abs(fit.optimum.u[j] - bound) < AT_BOUND * span):
            continue
        if side == "lower" and bound == 0.0 and parameter.transform != "log":
            yield f"{described} sits at 0: this recording shows nothing of it"
        else:
            yield f"{described} sits on its {side} bound; its standard error is meaningless"


def _about_misfit(fit: Fit, *, advise: bool) -> Iterator[str]:
    if fit.error > MISFIT:
        advice = "; `vegrip diagnose` looks for what is missing" if advise else ""
        yield f"the model leaves {fit.error:.2f} times the noise{advice}"
    if fit.error < GENEROUS:
        yield (
            f"the model leaves {fit.error:.2f} times the noise, so the noise was taken to be too large; what "
            "is less than it goes unseen"
        )
    if fit.error < HOPELESS or fit.problem.measured.noise.tolerance:
        return
    recording = fit.problem.measured.recording
    missed = fit.channels["normal_force"].rmse / float(np.nanmax(np.abs(recording.columns["normal_force"])))
    suspects = list(suspect_columns(recording.episode, recording.columns, recording.fingertip.radius))
    if missed > GROSS or suspects:
        yield (
            f"the force is missed by {100.0 * missed:.2g} % of its peak, which no effect makes up for: check "
            "columns, units, signs and zeros of the recording and the radius of the tip before all else"
        )
    else:
        yield (
            "no model of this kind may be right to the noise here; --tolerance 0.01 asks for 1 % of each "
            "episode's peak force, and keeps the deepest press from deciding alone"
        )


def _airless(fit: Fit) -> Iterator[str]:
    if not np.any(fit.problem.table(fit.optimum.u)[:, AT["contact_radius"]] == 0.0):
        yield AIRLESS


def _missing(fit: Fit) -> Iterator[str]:
    measured = fit.problem.measured
    if not measured.sliding.size:
        yield "no row slides under a measured load: friction and pressure profile stay with the prior"
    touching = np.count_nonzero(fit.problem.stiffness > 0.0)
    if touching < 50:
        yield f"only {touching} rows are in contact; the values are uncertain"
    is_shallow = np.nanmax(measured.motion.displacement) < 0.2 * fit.problem.depth
    if is_shallow:
        yield "the deepest indentation is under 2 % of the radius: is the radius right?"
    force = measured.force[np.isfinite(measured.force)]
    top = force.max()
    flat = np.count_nonzero(force > top - 0.5 * measured.noise.normal_force)
    if flat > max(20, 0.002 * force.size) and np.count_nonzero(force == top) > 10:  # as at the end of a scale
        yield f"the force ends flat at {top:.4g} N in {flat} rows: the sensor may saturate"
