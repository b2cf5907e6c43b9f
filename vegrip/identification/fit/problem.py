"""The least-squares problem of a model and a recording: what the model leaves, in units of the noise.

Three blocks, one below the other: the normal force (every row, whitened), the load at slip (rows that slide),
the contact radius (rows that see it). Unknown are the coordinates of the model's parameters, the zeros of
both sensors, for the recording or for each episode, and where each place that was pressed has laws of its
own, how far its parameters lie from the common ones.
"""

import math
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from vegrip.errors import RecordingError
from vegrip.identification.fit import whitening
from vegrip.identification.fit.gaps import unseen_bumps
from vegrip.identification.fit.preprocess import Measured
from vegrip.identification.fit.unfelt import unfelt
from vegrip.identification.recording import Recording
from vegrip.model import BASE, ContactModel, Predictor
from vegrip.model.channels import QUANTITIES
from vegrip.parameters import coordinate
from vegrip.types import Floats

Zeros = Literal["recording", "episode"] | tuple[int, ...]
"""What has zeros, or laws, of its own: the recording, each episode, or a group of episodes: the number of the
group of each."""

OWN_MARK = "_at_"  # in the names of what a place has for itself
OWN_STDS = 5.0  # standard deviations of the prior, within which a place differs from the others
OWN_LOG_SCALE = 1.0  # and the greatest of the logarithm by which a value differs
OF_SURFACES = {"area", "friction", "profile"}  # stages of an effect that is no matter of the place
AT = {name: i for i, name in enumerate(QUANTITIES)}
# the prior of a fit is this many times wider than declared, of the base model and of shapes
PRIOR_WIDENING = 3.0
VAGUE_LOG_SCALE = 5.0  # and that of a stiffness, whose unit may be a cell or a car tyre
FREE_ZERO = 0.5  # [x_ref], [greatest force] prior std and bound of the zeros
# standard deviations of the force: with less a model may take the surface for lifted, without radius
FIRM = 5.0
UNSURE = 0.07  # of the load at slip that noise may be
FORGOTTEN = 2.0  # relaxation times after a contact was made anew
LONGEST_GAP_S = 5.0  # [s]
DERIVATIVE_STEP = 1e-4  # of a prior std, for derivatives
MOST_DERIVATIVES = 1.5e8  # numbers of a table of them, of which a fit has two


class TooManyUnknownsError(RecordingError):
    """So many episodes have zeros or laws of their own that the derivatives would not fit into memory."""


@dataclass(frozen=True, eq=False)
class Unknowns:
    """Names, bounds and priors of what is fitted, in coordinates; zeros in x_ref and greatest force.

    Priors: the declared ones for the amount of an added effect; for what shapes it wider ones, and for the
    base model wide ones around the values it has, which matter only where the recording is silent.
    """

    names: tuple[str, ...]
    log: NDArray[np.bool_]
    place: NDArray[np.int64]  # in the model's vector, -1 for zeros
    start: Floats
    low: Floats
    high: Floats
    prior: Floats
    std: Floats

    def with_one(self, name: str, low: float, high: float, std: float) -> "Unknowns":
        """Return the same with one more at the end, which is no parameter of the model and absent at 0."""
        return Unknowns(
            (*self.names, name), np.append(self.log, False),
            np.append(self.place, -1), np.append(self.start, 0.0),
            np.append(self.low, low), np.append(self.high, high), np.append(self.prior, 0.0),
            np.append(self.std, std),
        )  # fmt: skip


class Problem:
    """Residuals and derivatives.

    Args:
        model: whose values are the start.
        measured: the recording.
        zeros: whether the zeros of the sensors are the recording's, each episode's or those of its group.
        laws: the same of stiffness and relaxation of the base model; friction and added effects are common:
            what a place has for itself, no other place can contradict. No press before has touched another
            place, so each group starts with no history.
        symbols: parameters to fit; those with a standard deviation when not given.
        like: a problem whose rows, noise, zeros and laws to share, so that models can be compared; else the
            noise is that at the start, until :meth:`freeze`.
        within: a model that has all effects of ``model`` and more, those absent; it is what runs.

    """

    _pressed: Sequence[slice | NDArray[np.int64]] = (slice(None),)  # rows of each place
    _unfelt: frozenset[str] = frozenset()  # parameters, by which derivatives are nothing
    threads = 1  # that find derivatives
    zeros: Zeros
    laws: Zeros
    doubtful: NDArray[np.bool_]
    stiffness: Floats
    whitener: whitening.Whitener
    force_std: Floats
    slip_std: Floats
    slip_bias: Floats
    _columns: dict[str, Floats]
    radius_std: Floats
    _predictors: list[Predictor]

    def __init__(
        self,
        model: ContactModel,
        measured: Measured,
        *,
        zeros: Zeros = "recording",
        laws: Zeros = "recording",
        symbols: tuple[str, ...] | None = None,
        like: "Problem | None" = None,
        within: ContactModel | None = None,
    ) -> None:
        self.model, self.measured = model, measured
        shown = {"shows_slip": measured.sliding.size > 0, "shows_radius": measured.seen.size > 0}
        self._unfelt = unfelt(model, **shown)
        self._columns = measured.columns if like is None else like._columns
        asked = np.zeros(len(measured.recording))
        asked[measured.seen], asked[measured.sliding] = 1.0, 2.0
        runs = within or model
        self.zeros, self.laws = (zeros, laws) if like is None else (like.zeros, like.laws)
        self.episodes = np.cumsum(measured.first > 0.0).astype(np.int64) - 1
        self._owner = _owners(self.zeros, self.episodes, measured.recording)
        self.places = _owners(self.laws, self.episodes, measured.recording)
        count = int(self.places.max()) + 1
        if count > 1:
            self._pressed = [np.flatnonzero(self.places == i) for i in range(count)]
        self._refuse_too_many(len(asked) + int(np.sum(asked > 0.0)))
        if like is not None and like.model.reference_temperature == runs.reference_temperature:
            self._predictors = [one.of(runs) for one in like._predictors]
        else:
            of_place = [{name: one[rows] for name, one in self._columns.items()} for rows in self._pressed]
            given = zip(of_place, self._pressed, strict=True)
            self._predictors = [Predictor(runs, columns, asked=asked[rows]) for columns, rows in given]
        self._places = {symbol: i for i, symbol in enumerate(runs.parameters)}
        self._vector = runs.vector
        for symbol, value in model.values.items():
            self._vector[self._places[symbol]] = value.value
        self.depth = model.reference_depth
        self.load = float(np.nanmax(np.abs(measured.force)))
        self.unknowns = self._unknowns(symbols)
        if like is None:
            self.doubtful = np.zeros(self.episodes.size, dtype=bool)
            self.freeze(self.unknowns.start)
        else:
            self.doubtful, self.stiffness, self.whitener = like.doubtful, like.stiffness, like.whitener
            self.threads = like.threads
            self.force_std, self.radius_std = like.force_std, like.radius_std
            self.slip_std, self.slip_bias = like.slip_std, like.slip_bias

    def _refuse_too_many(self, rows: int) -> None:
        owners, places = int(self._owner.max()) + 1, len(self._pressed)
        unknowns = len(self.model.parameters) + 2 * owners + places * len(self.own_symbols)
        if max(owners, places) > 1 and rows * unknowns > MOST_DERIVATIVES:
            raise TooManyUnknownsError(
                f"{max(owners, places)} episodes with zeros or laws of their own are {unknowns} unknowns for"
                f" {rows} rows: the derivatives would take {8e-9 * rows * unknowns:.0f} GB; let the episodes"
                " have them in common, or give fewer of them"
            )

    @property
    def symbols(self) -> tuple[str, ...]:
        return tuple(n for n, at in zip(self.unknowns.names, self.unknowns.place, strict=True) if at >= 0)

    def _unknowns(self, symbols: tuple[str, ...] | None) -> Unknowns:
        known = self.model.parameters
        names = [s for s in known if self.model.values[s].std > 0.0] if symbols is None else list(symbols)
        declared = [known[s][1] for s in names]
        values = [self.model.values[s] for s in names]
        zeros, places = int(self._owner.max()) + 1, len(self._pressed)
        kinds = () if self.measured.recording.is_step else ("zero_displacement", "zero_force")
        extra = [f"{kind}{i if zeros > 1 else ''}" for kind in kinds for i in range(zeros)]
        place = [self._places[s] for s in names]

        # a first touch that lies deeper, or long before the record began, is no zero but another law

        def joined(inner: list[float], zero: float, beside: Sequence[float] = ()) -> Floats:
            return np.array([*inner, *[zero] * len(extra), *(beside or [0.0] * len(own))], dtype=np.float64)

        base = [known[s][0] in BASE for s in names]
        wide = [
            VAGUE_LOG_SCALE if p.symbol == "K" else p.std * (PRIOR_WIDENING if own or p.null is None else 1.0)
            for p, own in zip(declared, base, strict=True)
        ]
        middle = [
            coordinate(p, v.value if own else p.default)
            for p, v, own in zip(declared, values, base, strict=True)
        ]
        own = {
            own_name(p.symbol, i): min(std if p.transform == "log" else std / p.default, OWN_LOG_SCALE)
            for p, std in zip(declared, wide, strict=True)
            if p.symbol in self.own_symbols
            for i in range(places)
        }
        bounds = [OWN_STDS * std for std in own.values()]
        lows, highs = (
            [_bound(p.transform, value) for p, value in zip(declared, ends, strict=True)]
            for ends in ([v.low for v in values], [v.high for v in values])
        )
        return Unknowns(
            (*names, *extra, *own),
            np.array([p.transform == "log" for p in declared] + [False] * (len(extra) + len(own))),
            np.array([*place, *[-1] * (len(extra) + len(own))], dtype=np.int64),
            joined([coordinate(p, v.value) for p, v in zip(declared, values, strict=True)], 0.0),
            joined(lows, -FREE_ZERO, [-bound for bound in bounds]),
            joined(highs, FREE_ZERO, bounds),
            joined(middle, 0.0),
            joined(wide, FREE_ZERO, list(own.values())),
        )

    def parts(self, u: Floats) -> tuple[Floats, tuple[Floats, Floats]]:
        """Return the model's vector and the zeros (n,) of displacement [m] and force [N]."""
        vector = self._vector.copy()
        inner = self.unknowns.place >= 0
        raw = u[inner]
        vector[self.unknowns.place[inner]] = np.where(
            self.unknowns.log[inner], np.exp(np.where(self.unknowns.log[inner], raw, 0.0)), raw
        )
        n = int(self._owner.max()) + 1
        is_known = self.measured.recording.is_step
        zero = np.zeros(2 * n) if is_known else u[~inner]
        depth, load = self.depth * zero[:n], self.load * zero[n : 2 * n]
        if n == 1:
            return vector, (np.full(self._owner.size, depth[0]), np.full(self._owner.size, load[0]))
        return vector, (depth[self._owner], load[self._owner])

    def depth_at_rest(self, u: Floats) -> Floats:
        """Return how deep the unloaded surface would lie (n,) [m]: the displacement without its zero."""
        depth: Floats = self.measured.motion.displacement - self.parts(u)[1][0]
        return depth

    def at(self, symbol: str) -> int:
        """Return where a parameter stands in the vector of :meth:`parts`."""
        return self._places[symbol]

    @property
    def own_symbols(self) -> list[str]:
        """The parameters that each place has for itself: stiffness and relaxation of the base model."""
        effects = self.model.effects if len(self._pressed) > 1 else ()
        own = [e for e in effects if e.name in BASE and not OF_SURFACES & {hook.stage for hook in e.hooks}]
        return [p.symbol for e in own for p in e.parameters]

    def own_laws(self, vector: Floats, u: Floats) -> Floats:
        """Return the ``vector`` of :meth:`parts` with the values of each place, (places, values)."""
        own, names = np.tile(vector, (len(self._pressed), 1)), self.unknowns.names
        for symbol in self.own_symbols:
            if (name := own_name(symbol, 0)) in names:
                at, first = self._places[symbol], names.index(name)
                declared = self.model.parameters[symbol][1]
                moved = own[:, at] * np.exp(u[first : first + len(own)])
                own[:, at] = np.clip(moved, declared.low, declared.high)
        return own

    def _predict(
        self,
        u: Floats,
        moved: float | Floats = 0.0,
        speed: Floats | None = None,
        instead: Mapping[str, float] | None = None,
    ) -> Floats:
        """Return the prediction (n, 14) with a displacement that is ``moved`` (n,) [m] deeper."""
        vector, (depth, force) = self.parts(u)
        for symbol, value in (instead or {}).items():
            vector[self._places[symbol]] = value
        depth = depth - moved if np.any(moved) else depth
        if len(self._pressed) == 1:
            return self._predictors[0](vector, (depth, force), speed)
        out = np.empty((len(QUANTITIES), depth.size)).T
        laws = self.own_laws(vector, u)
        for law, rows, predictor in zip(laws, self._pressed, self._predictors, strict=True):
            at = None if speed is None else speed[rows]
            out[rows] = predictor(law, (depth[rows], force[rows]), at)
        return out

    def table(self, u: Floats, instead: Mapping[str, float] | None = None) -> Floats:
        """Return the prediction (n, 14), radius and load only of rows that inform.

        The normal force is with the zero of its sensor.

        ``instead``: values of parameters that are not among the unknowns.
        """
        out = self._predict(u, instead=instead)
        out[:, AT["normal_force"]] += self.parts(u)[1][1]
        return out

    def freeze(self, u: Floats) -> None:
        """Set up the noise of every block at ``u``."""
        m, noise = self.measured, self.measured.noise
        here = self.table(u)
        _, zeros = self.parts(u)
        h = 1e-3 * self.depth
        beyond = self._predict(u, h)
        rise = (beyond[:, AT["elastic_force"]] - here[:, AT["elastic_force"]]) / h
        touching = here[:, AT["normal_force"]] - zeros[1] != 0.0
        self.stiffness = np.where(touching, np.maximum(rise, 0.0), 0.0)
        self.whitener = whitening.Whitener(
            m.recording.t,
            m.first,
            m.motion,
            self._sensitivity(u),
            noise.of_force(m.force, self.episodes),
            self.used.astype(np.float64),
        )
        self.force_std = self.whitener.std
        self.slip_std, self.slip_bias = self._slip_noise(here)
        slope = (beyond[:, AT["contact_radius"]] - here[:, AT["contact_radius"]]) / h
        radius_std = np.hypot(np.nan_to_num(noise.contact_radius), np.abs(slope) * m.motion.std)
        firm = np.fmin(m.force, here[:, AT["normal_force"]]) - zeros[1] > FIRM * self.force_std
        self.radius_std = np.where(self.doubtful | ~firm, np.inf, radius_std)[m.seen]

    def _sensitivity(self, u: Floats) -> whitening.Sensitivity:
        m, plain = self.measured, whitening.by_position(self.stiffness)
        tip, speed, bend = plain.follows, plain.speed, plain.bend
        noise = m.noise.displacement
        if whitening.has_play(self.model) and noise > 0.0:

            def indentation(moved: Floats) -> Floats:
                return self._predict(u, moved)[:, AT["indentation"]]

            tip = whitening.follows(indentation, m.first, m.motion.displacement, noise)
        if whitening.feels_speed(self.model):

            def force(at: Floats) -> Floats:
                return self._predict(u, speed=at)[:, AT["normal_force"]]

            speed, bend = whitening.by_speed(force, m.recording.t, m.first, m.motion)
        memory = plain.memory
        if m.gaps.size:
            bumps = unseen_bumps(m.recording.t, m.first, self.depth_at_rest(u), m.gaps)
            with np.errstate(invalid="ignore"):  # values that lead nowhere are left by the steps of the fit
                kept = self._predict(u, bumps) - self._predict(u)
            memory = np.where(bumps > 0.0, 0.0, kept[:, AT["normal_force"]])
        return whitening.Sensitivity(self.stiffness, speed, tip, bend, memory, m.gaps[:, 1])

    @property
    def log_scale(self) -> Floats:
        """Logarithm of the std of every residual (rows,): the likelihood's part that the noise makes."""
        beside = np.concatenate([self.slip_std, self.radius_std])
        return np.concatenate([self.whitener.log_scale, np.log(np.where(np.isfinite(beside), beside, 1.0))])

    @property
    def used(self) -> NDArray[np.bool_]:
        return np.isfinite(self.measured.force) & ~self.doubtful

    def doubted(self, u: Floats) -> NDArray[np.bool_]:
        """Return the rows (n,) after the contact parted and was made again within an episode.

        A tip withdrawn faster than it recovers parts from the object while it is still dented. Whether its
        surface then recovers freely, as the model has it, or as if it were still held, as equation (20) of
        [TiezziKao2007]_ cut off at zero has it, makes up to a few percent of the force at the next touch,
        and is no evidence of anything else. Two relaxation times later it is forgotten.
        Where a recording says that its episodes begin unrecovered, that history is what is to be fitted.
        """
        rows = np.zeros(self.episodes.size, dtype=bool)
        if not self.measured.recovered:
            return rows
        out = self.table(u)
        vector, (_, zero_force) = self.parts(u)
        dented = (out[:, AT["indentation"]] > 0.0) & (out[:, AT["contact_radius"]] == 0.0)
        rates = [vector[self._places["nu1"]]] if "nu1" in self._places else []
        memory = min(FORGOTTEN / max(rates[0], 1e-9), LONGEST_GAP_S) if rates else LONGEST_GAP_S
        t, since = self.measured.recording.t, -math.inf
        rising = np.gradient(self.measured.motion.displacement, t) > 0.0
        pressing = out[:, AT["normal_force"]] - zero_force
        # zeros that are far off make contacts of the air, so the sensor has to read a load as well
        firm = np.fmin(self.measured.force, pressing) > FIRM * self.force_std
        concerned = (out[:, AT["indentation"]] > 0.0) & (rising | ~dented)
        for i in range(t.size):
            if self.measured.first[i] > 0.0:
                since, has_held = t[i] if firm[i] else -math.inf, False
            has_held = has_held or bool(firm[i])
            if dented[i] and has_held:
                since = t[i]
            rows[i] = concerned[i] and t[i] - since < memory
        return rows

    def _slip_noise(self, here: Floats) -> tuple[Floats, Floats]:
        """Return std and mean of what noise makes of ln utilisation, by the ellipse with the same half axes.

        With ``u^2 = f^2 + q^2``, force and torque in units of their limits, noise s_f (of both components)
        and s_q shifts ln u by ``(2 s_f^2 + s_q^2) / (2 u^2) - (f^2 s_f^2 + q^2 s_q^2) / u^4``. Slips of which
        the noise is no small part, where that expansion ends, do not count.
        """
        noise, rows = self.measured.noise, self.measured.sliding
        limit = np.maximum(here[rows, AT["limit_force"]], 1e-300)
        torsion = np.maximum(here[rows, AT["limit_torque"]], 1e-300)
        fx, fy, torque = self._loads()
        root = np.sqrt(self.measured.stretch)
        f, q = np.hypot(fx, fy) / limit, np.abs(torque) / torsion
        s_f = np.nan_to_num(noise.tangential_force) / limit / root
        s_q = np.nan_to_num(noise.torque_z) / torsion / root
        load = noise.normal_force / np.maximum(here[rows, AT["contact_force"]], noise.normal_force) / root
        with np.errstate(over="ignore", invalid="ignore"):  # nothing is sure where the model does not touch
            u2 = np.maximum(f * f + q * q, 1e-12)
            along = ((f * s_f) ** 2 + (q * s_q) ** 2) / u2**2
            std = np.sqrt(along + load**2)
            bias = (2.0 * s_f**2 + s_q**2) / (2.0 * u2) - along + 0.5 * load**2
        sure = (std < UNSURE) & (bias < UNSURE)
        return np.where(sure, std, np.inf), np.where(sure, bias, 0.0)

    def _loads(self) -> tuple[Floats, Floats, Floats]:
        rows, columns = self.measured.sliding, self._columns
        none = np.zeros(len(self.measured.recording))
        fx, fy, torque = (
            np.nan_to_num(columns.get(name, none)[rows])
            for name in ("tangential_force_x", "tangential_force_y", "torque_z")
        )
        return fx, fy, torque

    def raw(self, table: Floats) -> tuple[Floats, Floats, Floats]:
        """Return what the model leaves: force [N] (n,), ln utilisation (k,), radius [m] (m,)."""
        m = self.measured
        force = np.nan_to_num(m.force - table[:, AT["normal_force"]])
        used = table[m.sliding, AT["utilisation"]]
        slip = np.log(np.where(np.isfinite(used) & (used > 0.0), used, 1.0)) - self.slip_bias
        radius = m.recording.columns.get("contact_radius", np.zeros(len(m.recording)))[m.seen]
        return force, slip, radius - table[m.seen, AT["contact_radius"]]

    def white(self, raw: tuple[Floats, Floats, Floats]) -> Floats:
        return np.concatenate([self.whitener(raw[0]), raw[1] / self.slip_std, raw[2] / self.radius_std])

    def standardised(self, raw: tuple[Floats, Floats, Floats]) -> Floats:
        """Return the blocks over the std of each row, in place: not independent where noise is slow."""
        force = np.where(self.used, raw[0] / self.force_std, 0.0)
        return np.concatenate([force, raw[1] / self.slip_std, raw[2] / self.radius_std])

    def residual(self, u: Floats) -> Floats:
        return self.white(self.raw(self.table(u)))

    def jacobian(
        self, u: Floats, residual: Floats | None = None, known: Mapping[str, Floats] | None = None
    ) -> Floats:
        """Return the derivative of :meth:`residual`, (rows, unknowns), by differences away from bounds.

        ``known``: columns to be taken as they are, by the names of the unknowns.
        """
        base = self.residual(u) if residual is None else residual
        out, every = np.zeros((base.size, u.size)), np.arange(base.size)
        k = self.unknowns

        def derive(group: tuple[list[int], NDArray[np.int64]]) -> None:
            together, owner = group
            j, is_alone = together[0], len(together) == 1
            if k.names[j] in self._unfelt:
                return
            if known is not None and k.names[j] in known:
                out[:, together] = np.stack([known[k.names[i]] for i in together], axis=1)
                return
            own = (slice(None), j) if is_alone else (every, np.array(together)[owner[self.rows]])
            if k.names[j].startswith("zero_force") and self._adds_zero_force:
                none = np.zeros(0)
                out[own] = self.white(
                    (np.where(np.isfinite(self.measured.force), -self.load, 0.0), none, none)
                )
                return
            h = DERIVATIVE_STEP * k.std[j]
            h = -h if (u[together] + h > k.high[together]).any() else h
            moved = u.copy()
            moved[together] += h
            out[own] = (self.residual(moved) - base) / h

        with ThreadPoolExecutor(self.threads) as pool:
            list(pool.map(derive, self._columns_at_once))
        return out

    @property
    def _adds_zero_force(self) -> bool:
        """Whether the zero of the force is added to the model's force and does no more, in no friction."""
        is_driven = any(one.is_by_force for one in self._predictors)
        return not (is_driven or self.measured.sliding.size or self.measured.seen.size)

    @property
    def _columns_at_once(self) -> list[tuple[list[int], NDArray[np.int64]]]:
        """The unknowns, in groups of which each row feels only one, and which (n,).

        Those of a group need one evaluation together: the laws of the places, the zeros of the force, and
        those of the displacement unless an effect remembers an episode that is past.
        """
        names, places = self.unknowns.names, range(len(self._pressed))
        own = [([own_name(symbol, i) for i in places], self.places) for symbol in self.own_symbols]
        if "zero_force0" in names:
            lasts = any(s.lasting for e in self.model.effects for s in e.states)
            kinds = ("zero_force",) if lasts else ("zero_force", "zero_displacement")
            zeros = range(int(self._owner.max()) + 1)
            own += [([f"{kind}{i}" for i in zeros], self._owner) for kind in kinds]
        some = [([names.index(one) for one in of], owner) for of, owner in own if of[0] in names]
        grouped = {j for of, _ in some for j in of}
        nothing = np.zeros(0, dtype=np.int64)
        return [([j], nothing) for j in range(len(names)) if j not in grouped] + some

    @property
    def rows(self) -> NDArray[np.int64]:
        m = self.measured
        return np.concatenate([np.arange(len(m.recording)), m.sliding, m.seen])

    @property
    def counted(self) -> NDArray[np.bool_]:
        return np.concatenate([self.used, np.isfinite(self.slip_std), np.isfinite(self.radius_std)])


def own_name(symbol: str, place: int) -> str:
    """Return the name of the unknown by which ``symbol`` of one place differs from the common one."""
    return f"{symbol}{OWN_MARK}{place}"


def is_own_name(unknown: str) -> bool:
    return OWN_MARK in unknown


def _owners(zeros: Zeros, since: NDArray[np.int64], recording: Recording) -> NDArray[np.int64]:
    if zeros == "recording":
        return np.zeros_like(since)
    if zeros == "episode":
        return since
    _, episode = np.unique(recording.episode, return_inverse=True)
    _, group = np.unique(zeros, return_inverse=True)
    return np.asarray(group[episode], dtype=np.int64)


def _bound(transform: str, value: float) -> float:
    if transform == "log":
        return math.log(value) if value > 0.0 else -math.inf
    return value
