"""What a rest, a press, a shear and a twist show of a proposed map: zeros, noise, signs, what is what.

Each is a window of time [s] of the traffic. A press is one of a fingertip against something, along its
normal; a shear pulls it along its +x; a twist turns what it touches counter-clockwise about its outward
normal. Without windows the quietest second is the rest, and the larger excursion of the normal force is
compression.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from vegrip.connect import drafts
from vegrip.connect.proposal import Proposal, option_of, signals_of
from vegrip.connect.traffic import Trace, rate_of
from vegrip.errors import InputError
from vegrip.transport.maps.database import Database
from vegrip.transport.maps.map_text import Setting
from vegrip.transport.maps.units import SI
from vegrip.types import Floats

Window = tuple[float, float]
FORCES: Final = ("normal_force", "tangential_force_x", "tangential_force_y")
ZEROED: Final = (*FORCES, "torque_z")
MIN_RESPONSE_STD: Final = 8.0  # standard deviations at rest that a response must exceed
MIN_HELD_STATES: Final = 1.2  # states per value from which a message counts as slower than the states
QUIET: Final = 1.0  # [s] of the window that is searched for a rest
QUIET_RATIO: Final = 1.5  # times the least change in a second: as quiet
STIFFNESS: Final = (10.0, 1e6)  # [N/m] of a soft fingertip and what it touches
LARGEST_FORCE: Final = 300.0  # [N] that a fingertip carries
LARGEST_RATIO: Final = 2.5  # of tangential to normal force: no friction is larger for long
SLIP_LEVEL: Final = 0.25  # of the way from the rest of a slip channel to its largest value
UNEQUAL: Final = 1.5  # times the response of another signal: then the names are wrong


def learn(
    proposal: Proposal,
    received: Mapping[str, Trace],
    windows: Mapping[str, Window],
    database: Database,
    settings: Sequence[Setting] = (),
) -> None:
    """Set zeros, signs and noise in ``proposal`` where ``settings`` do not, and say what was found."""
    fingers = [
        _Finger(name, f, received, windows, database, proposal) for name, f in proposal.fingers.items()
    ]
    for finger in fingers:
        finger.find_places()
    if "rest" not in windows and fingers and fingers[0].rest is not None:
        proposal.learned.append(
            f"rest is taken to be {fingers[0].rest[0]:.1f}..{fingers[0].rest[1]:.1f} s, the first quiet "
            "second; --rest A..B says another"
        )
    _inherit_places(proposal)
    drafts.apply_settings(proposal.fingers, settings)
    for finger in fingers:
        finger.learn()
    _inherit(proposal)
    for finger in fingers:
        finger.doubt_touch()
    has_force = any("normal_force" in f.channels or f.taxels for f in proposal.fingers.values())
    if "press" in windows and not has_force:
        raise InputError(fingers[0].without_force())
    if "press" in windows and not any("presses" in text for text in proposal.learned):
        proposal.implausible.append(
            "no finger answers to the press: nothing mapped as normal force moves in that "
            "window; look at the window and at the signals"
        )


class _Finger:
    def __init__(
        self,
        name: str,
        finger: drafts.FingerDraft,
        received: Mapping[str, Trace],
        windows: Mapping[str, Window],
        database: Database,
        proposal: Proposal,
    ) -> None:
        self.name, self.finger, self.received, self.windows = name, finger, received, windows
        self.proposal, self.database = proposal, database
        self.rest = windows.get("rest") or _quietest(finger, received)
        self.is_touch_known = True

    def without_force(self) -> str:
        left = self.received.keys() - set(signals_of(self.proposal)) if self.rest is not None else ()
        answers = {
            name: abs(self._response(name, self.windows["press"])) / self._spread(name) for name in left
        }
        best = max(sorted(answers), key=lambda name: answers[name], default="")
        if not best or not answers[best]:
            return f"{self.database.name}: no signal is mapped as normal force, and none answers to the press"
        option = option_of(best, self.proposal, self.database)
        return (
            f"{self.database.name}: no signal is mapped as normal force and nothing is written; {best} "
            f"answers to the press most: {option}, with what one count is worth"
        )

    def find_places(self) -> None:
        if self.rest is None:
            return
        if "press" in self.windows:
            self._find_normal(self.windows["press"])
        if "shear" in self.windows:
            self._find_shear(self.windows["shear"])

    def learn(self) -> None:
        if self.rest is None:
            return
        self._moving()
        self._slip_level()
        for channel in ZEROED:
            self._zero(channel)
        for channel in (*FORCES, "torque_z", "displacement", "temperature", "contact_radius"):
            self._noise(channel)
        self._signs()
        self._touch()
        self._check()

    def _moving(self) -> None:
        """A signal that moved is measured, also at zero; one that never moved is reported."""
        for channel, draft in self.finger.channels.items():
            if channel == "normal_force" or draft.signal not in self.received:
                continue
            raw = self.received[draft.signal].raw
            if np.any(raw != 0.0):
                draft.set("zero_is_measured", True, "it was not always zero in the traffic")
            else:
                self.proposal.learned.append(
                    f"{self.name}: {draft.signal} has been zero all the time, so {channel} counts as missing "
                    "until it moves"
                )

    def _slip_level(self) -> None:
        """A slip channel that is a level and no flag says slip a quarter of the way above its rest."""
        draft = self.finger.channels.get("slip")
        if draft is None or draft.signal not in self.received or "above" in draft.keys or self.rest is None:
            return
        trace = self.received[draft.signal]
        still, highest = trace.within(self.rest), float(np.max(trace.value))
        if highest <= 1.0 or not len(still) or highest <= float(np.max(still)):
            return
        level = float(np.max(still))
        above = float(f"{level + SLIP_LEVEL * (highest - level):.4g}")
        draft.set("above", above, f"its rest is at most {level:g}, its largest {highest:g}")

    def _draft(self, channel: str) -> drafts.Draft | None:
        """The draft of a channel that is one signal, received, and linear; a table or a threshold is not."""
        draft = self.finger.channels.get(channel)
        if draft is None or draft.signal not in self.received:
            return None
        return None if "table" in draft.keys or "above" in draft.keys else draft

    def _trace(self, draft: drafts.Draft) -> Trace:
        trace, keys = self.received[draft.signal], draft.keys
        values = trace.raw if keys.get("raw") else trace.value
        return Trace(
            trace.t, values * float(keys.get("scale", 1.0)) + float(keys.get("offset", 0.0)), trace.raw
        )

    def _resolution(self, draft: drafts.Draft) -> float:
        step = 1.0 if draft.keys.get("raw") else _step(self.database, draft.signal)
        return step * abs(float(draft.keys.get("scale", 1.0)))

    def _response(self, signal: str, window: Window) -> float:
        """How far ``signal`` goes from its rest in ``window``, with its sign; 0 within its noise."""
        assert self.rest is not None  # noqa: S101 (looked at by learn)
        trace = self.received[signal]
        still, moved = trace.within(self.rest), trace.within(window)
        if not len(still) or not len(moved):
            return 0.0
        far = moved - np.median(still)
        low, high = map(float, np.percentile(far, (3.0, 97.0)))
        peak = high if abs(high) >= abs(low) else low
        noise = max(float(np.std(still)), _step(self.database, signal))
        return peak if abs(peak) > MIN_RESPONSE_STD * noise else 0.0

    def _candidates(self) -> dict[str, drafts.Draft]:
        found = {d.signal: d for c in FORCES if (d := self._draft(c)) is not None}
        for one in self.finger.others:
            if one.name in self.received:
                found[one.name] = drafts.Draft(
                    {"signal": one.name, "unit": self.database.signal(one.name).unit}
                )
        return found

    def _strengths(self, candidates: Mapping[str, drafts.Draft], window: Window) -> dict[str, float]:
        """How far each goes in ``window``: in newtons, or where a unit does not show, in steps of noise."""
        comparable = not any(
            drafts.is_of_unknown_unit("normal_force", draft) for draft in candidates.values()
        )
        return {
            signal: abs(self._response(signal, window))
            * (abs(drafts.factor("normal_force", draft)) if comparable else 1.0 / self._spread(signal))
            for signal, draft in candidates.items()
        }

    def _spread(self, signal: str) -> float:
        assert self.rest is not None  # noqa: S101 (looked at by find_places)
        still = self.received[signal].within(self.rest)
        return max(float(np.std(still)) if len(still) else 0.0, _step(self.database, signal), 1e-12)

    def _find_normal(self, window: Window) -> None:
        best = self._place("normal_force", self._candidates(), window, "it answers to the press most")
        if not best:
            return
        normal = self.finger.channels["normal_force"]
        normal.notes["placed"] = "by the press"
        self.proposal.learned.append(f"{self.name} presses on {normal.signal}")

    def _find_shear(self, window: Window) -> None:
        normal = self._draft("normal_force")
        candidates = {s: d for s, d in self._candidates().items() if normal is None or s != normal.signal}
        best = self._place("tangential_force_x", candidates, window, "it answers to the shear most")
        left = [signal for signal in candidates if signal != best]
        if best and "tangential_force_y" not in self.finger.channels and len(left) == 1:
            self._swap("tangential_force_y", left[0], "the force that is left; its sign is not known")

    def _place(self, channel: str, candidates: Mapping[str, drafts.Draft], window: Window, why: str) -> str:
        """Give ``channel`` the signal that moves most in ``window``; return its signal, "" if none moves."""
        strength = self._strengths(candidates, window)
        best = max(strength, key=lambda signal: strength[signal], default="")
        if not best or not strength[best]:
            return ""
        present = self.finger.channels.get(channel)
        now = present.signal if present is not None else ""
        if present is not None and present.is_set_by_user("signal"):
            return now if strength.get(now) or channel != "normal_force" else ""
        if best != now and strength[best] > UNEQUAL * strength.get(now, 0.0):
            self._swap(channel, best, why)
        return best

    def _swap(self, channel: str, signal: str, why: str) -> None:
        """Give ``signal`` to ``channel``; what had it before gets what was there."""
        channels = self.finger.channels
        before = next((c for c in FORCES if c in channels and channels[c].signal == signal), None)
        replaced = channels.get(channel)
        unit = self._candidates()[signal].keys.get("unit", "")
        channels[channel] = drafts.Draft({"signal": signal, "unit": unit}, {"signal": why})
        if before is not None and before != channel:
            del channels[before]
            if replaced is not None:
                channels[before] = drafts.Draft(dict(replaced.keys), {"signal": f"{signal} is the {channel}"})
        self.proposal.learned.append(f"{self.name}: {signal} is {channel}: {why}")

    def _zero(self, channel: str) -> None:
        draft = self._draft(channel)
        if draft is None or self.rest is None or draft.is_set_by_user("zero"):
            return
        still = self._trace(draft).within(self.rest)
        if not len(still):
            return
        mean, error = float(np.mean(still)), float(np.std(still)) / math.sqrt(len(still))
        if abs(mean) > max(4.0 * error, 0.5 * self._resolution(draft)):
            draft.set("zero", float(f"{mean:.6g}"), "the mean at rest")

    def _noise(self, channel: str) -> None:
        draft = self._draft(channel)
        if draft is None or self.rest is None or draft.is_set_by_user("noise"):
            return
        still = self._trace(draft).within(self.rest)
        if len(still) < 10:
            return
        spread = float(np.std(np.diff(still))) / math.sqrt(2.0)  # of neighbours: a drift is no noise
        least = self._resolution(draft) / math.sqrt(12.0)
        times = self._states_per_value(draft.signal)
        late = self._lateness(draft, spread) if times > 1.0 else 0.0
        size = math.hypot(max(spread, least), late) * abs(drafts.factor(channel, draft)) * math.sqrt(times)
        why = f"[{SI[channel]}] standard deviation at rest"
        if times > 1.0:
            why += f", and what a held value was late by, times the root of its {times:.3g} states"
        draft.set("noise", float(f"{size:.3g}"), why)

    def _lateness(self, draft: drafts.Draft, spread: float) -> float:
        """Return the rms error of a value that stands until the next one comes, while the fingertip moves.

        A value that changes by ``d`` until the next one is off by 0 to ``d``, evenly: ``d / sqrt(3)`` rms.
        """
        trace = self._trace(draft)
        moved = np.diff(trace.within(self.windows.get("press") or (float(trace.t[0]), float(trace.t[-1]))))
        changed = float(np.mean(moved**2)) - 2.0 * spread**2 if len(moved) else 0.0  # without the noise
        return math.sqrt(max(changed, 0.0) / 3.0)

    def _states_per_value(self, signal: str) -> float:
        rates = [
            rate_of(self.received[d.signal])
            for d in self.finger.channels.values()
            if d.signal in self.received
        ]
        own = rate_of(self.received[signal])
        ratio = max(rates) / own if own > 0.0 else 1.0
        return ratio if ratio > MIN_HELD_STATES else 1.0

    def _signs(self) -> None:
        self._sign("normal_force", self.windows.get("press"), "a press is positive")
        self._sign("tangential_force_x", self.windows.get("shear"), "the shear was along +x")
        self._sign("torque_z", self.windows.get("twist"), "the twist was counter-clockwise")
        displacement, normal = self._draft("displacement"), self._draft("normal_force")
        if displacement is None or normal is None:
            return
        slope = self._slope(normal, displacement, signed=True)
        if slope:
            self._turn(displacement, slope, "indentation grows with the normal force")

    def _sign(self, channel: str, window: Window | None, why: str) -> None:
        draft = self._draft(channel)
        if draft is None:
            return
        if window is None and channel == "normal_force":
            trace = self.received[draft.signal]
            window, why = (float(trace.t[0]), float(trace.t[-1])), "the larger excursion is compression"
        response = self._response(draft.signal, window) if window is not None else 0.0
        if response:
            self._turn(draft, response, why)

    def _turn(self, draft: drafts.Draft, response: float, why: str) -> None:
        if draft.is_set_by_user("sign"):
            return
        turned = draft.keys.get("sign", 1) * (1 if response > 0.0 else -1)
        draft.keys.pop("sign", None)
        if turned < 0:
            draft.set("sign", -1, why)
        draft.notes.setdefault("seen", why)

    def _slope(self, normal: drafts.Draft, displacement: drafts.Draft, *, signed: bool) -> float:
        """Return d(normal force)/d(displacement) in SI where the finger presses, 0 when it does not."""
        force, depth = self._si("normal_force", normal), self._si("displacement", displacement)
        t = self.received[normal.signal].t
        at = np.interp(t, self.received[displacement.signal].t, depth)
        window = self.windows.get("press")
        pressing = np.abs(force) > max(
            0.1 * float(np.max(np.abs(force))), MIN_RESPONSE_STD * float(normal.keys.get("noise", 0.0))
        )
        if window is not None:
            pressing &= (t >= window[0]) & (t <= window[1])
        if np.count_nonzero(pressing) < 10 or float(np.std(at[pressing])) == 0.0:
            return 0.0
        covariance = float(np.cov(force[pressing], at[pressing])[0, 1])
        return covariance / float(np.var(at[pressing])) if signed or covariance > 0.0 else 0.0

    def _si(self, channel: str, draft: drafts.Draft) -> Floats:
        return (self._trace(draft).value - float(draft.keys.get("zero", 0.0))) * drafts.factor(channel, draft)

    def _touch(self) -> None:
        """Indentation counts from the first touch: where the normal force leaves its noise."""
        displacement, normal = self._draft("displacement"), self._draft("normal_force")
        if displacement is None or normal is None or displacement.is_set_by_user("zero"):
            return
        force, t = self._si("normal_force", normal), self.received[normal.signal].t
        noise = MIN_RESPONSE_STD * float(normal.keys.get("noise", 0.0))
        for first, last in (self.windows.get("press", (t[0], t[-1])), (t[0], t[-1])):
            inside = (t >= first) & (t <= last)
            highest = float(np.max(force[inside])) if np.any(inside) else 0.0
            level = max(noise, 0.03 * highest)
            above = np.flatnonzero(inside & (force > level))
            before = np.flatnonzero(inside & (force < level))
            if len(above) and len(before) and before[0] < above[0]:
                break
        else:
            self.is_touch_known = False
            return
        trace = self._trace(displacement)
        half_way = above[force[above] > 0.5 * highest]
        end = half_way[0] if len(half_way) else above[-1]
        rise = np.arange(above[0], end + 1)
        at = np.interp(t[rise], trace.t, trace.value)
        zero = _first_touch(force[rise], at)
        if abs(zero) > 2.0 * self._resolution(displacement):
            why = "where the normal force begins: F^(2/3) of the first press, drawn on to zero"
            displacement.set("zero", float(f"{zero:.6g}"), why)

    def doubt_touch(self) -> None:
        """Leave out an indentation that is one in the air; where it only may be wrong, say so."""
        displacement = self._draft("displacement")
        if self.is_touch_known or displacement is None or self.rest is None:
            return
        t, (first, last) = self.received[displacement.signal].t, self.rest
        still = self._si("displacement", displacement)[(t >= first) & (t <= last)]
        in_air, left_out = float(np.median(still)) if still.size else 0.0, ""
        clear = MIN_RESPONSE_STD * float(displacement.keys.get("noise", 0.0))
        if in_air > clear and drafts.BY_USER not in displacement.notes.values():
            left_out = f", and it is left out: in the air it says {1e3 * in_air:.3g} mm"
            del self.finger.channels["displacement"]
        self.proposal.doubts.append(
            f"{self.name} was not pressed from the air, so where {displacement.signal} touches is not "
            f"known{left_out}: press it too, or say it: --set 'fingers.{self.name}.displacement={{ signal = "
            f'"{displacement.signal}", zero = VALUE }}\' [{displacement.keys.get("unit") or "m"}]'
        )

    def _check(self) -> None:
        normal, displacement = self._draft("normal_force"), self._draft("displacement")
        if normal is None:
            return
        force = self._si("normal_force", normal)
        if drafts.is_of_unknown_unit("normal_force", normal):
            return  # said elsewhere
        highest = float(np.percentile(force, 99.9))
        if highest > LARGEST_FORCE:
            self.proposal.implausible.append(
                f"{self.name}: the normal force comes to {highest:.3g} N, more than a fingertip carries; "
                f"its unit is not {normal.keys.get('unit') or 'SI'}: "
                f"--set fingers.{self.name}.normal_force.unit=mN"
            )
        if displacement is not None and not drafts.is_of_unknown_unit("displacement", displacement):
            slope = self._slope(normal, displacement, signed=False)
            if slope and not STIFFNESS[0] <= slope <= STIFFNESS[1]:
                self.proposal.implausible.append(
                    f"{self.name}: force over indentation is {slope:.3g} N/m, which no soft fingertip has "
                    f"({STIFFNESS[0]:g} .. {STIFFNESS[1]:g} N/m); the unit of one of the two is another"
                )
            elif slope:
                self.proposal.learned.append(f"{self.name}: stiffness {slope:.3g} N/m")
        self._check_friction(force, self.received[normal.signal].t)

    def _check_friction(self, force: Floats, t: Floats) -> None:
        normal = self.finger.channels["normal_force"]
        highest = float(np.max(force))
        if highest < MIN_RESPONSE_STD * float(normal.keys.get("noise", 0.0)):
            return  # it was not touched
        pressed = force > 0.2 * highest
        for channel in FORCES[1:]:
            draft = self._draft(channel)
            if draft is None or drafts.is_of_unknown_unit(channel, draft) or highest <= 0.0:
                continue
            shear = np.interp(t, self.received[draft.signal].t, self._si(channel, draft))
            ratio = float(np.median(np.abs(shear[pressed]) / force[pressed]))
            if ratio > LARGEST_RATIO:
                self.proposal.implausible.append(
                    f"{self.name}: {channel} is {ratio:.2g} times the normal force while it presses, more "
                    "than friction holds; the two are mixed up, or one has another unit"
                )


def _inherit(proposal: Proposal) -> None:
    """Give the signs that one finger showed to the others of its make that did not show their own."""
    shown: dict[tuple[str, str], tuple[str, drafts.Draft]] = {}
    for name, finger in proposal.fingers.items():
        for channel, draft in finger.channels.items():
            if "seen" in draft.notes:
                shown.setdefault((channel, draft.keys.get("unit", "")), (name, draft))
    for name, finger in proposal.fingers.items():
        for channel, draft in finger.channels.items():
            found = shown.get((channel, draft.keys.get("unit", "")))
            is_known = "seen" in draft.notes or draft.is_set_by_user("sign")
            if is_known or found is None or "sign" not in found[1].keys:
                continue
            draft.set("sign", -1, f"as at {found[0]}, which showed it")
            proposal.learned.append(f"{name}: {channel} turned round as at {found[0]}")


def _inherit_places(proposal: Proposal) -> None:
    shown = {
        name
        for name, f in proposal.fingers.items()
        if "placed" in f.channels.get("normal_force", drafts.Draft({})).notes
    }
    for name, finger in proposal.fingers.items():
        if name in shown or not shown:
            continue
        model = proposal.fingers[min(shown)]
        own = {d.signal: d for c, d in finger.channels.items() if c in FORCES}
        own |= {one.name: drafts.Draft({"signal": one.name}, {"signal": one.why}) for one in finger.others}
        places = {
            c: s if (s := finger.alike.get(d.signal, "")) in own else ""
            for c, d in model.channels.items()
            if c in FORCES
        }
        if not all(places.values()) or all(
            finger.channels.get(c, drafts.Draft({})).signal == s for c, s in places.items()
        ):
            continue
        for channel in [c for c, d in finger.channels.items() if c in FORCES and d.signal in places.values()]:
            del finger.channels[channel]
        for channel, signal in places.items():
            draft = own[signal]
            draft.keys.setdefault("unit", model.channels[channel].keys.get("unit", ""))
            finger.channels[channel] = drafts.Draft(
                dict(draft.keys), {**draft.notes, "signal": f"as at {min(shown)}, which showed it"}
            )
        proposal.learned.append(f"{name}: the forces are placed as at {min(shown)}")


def _quietest(finger: drafts.FingerDraft, received: Mapping[str, Trace]) -> Window | None:
    """Return the first second in which the forces of a finger hardly change, None without traffic.

    A hold is as quiet as a rest; what is logged begins with a rest more often than with a hold.
    """
    traces = [received[d.signal] for d in finger.channels.values() if d.signal in received]
    forces = [
        received[d.signal] for c, d in finger.channels.items() if c in FORCES and d.signal in received
    ] or traces
    if not forces:
        return None
    begin, end = min(float(trace.t[0]) for trace in forces), max(float(trace.t[-1]) for trace in forces)
    if end - begin <= QUIET:
        return begin, end
    starts = np.linspace(begin, end - QUIET, 200)
    unrest = [sum(_unrest(trace, (s, s + QUIET)) for trace in forces) for s in starts]
    first = float(starts[int(np.argmax(np.array(unrest) <= QUIET_RATIO * min(unrest)))])
    return first, first + QUIET


def _unrest(trace: Trace, window: Window) -> float:
    values = trace.within(window)
    whole = float(np.ptp(trace.value)) or 1.0
    return float(np.std(values)) / whole if len(values) > 2 else math.inf


def _first_touch(force: Floats, at: Floats) -> float:
    """Return where the force of a Hertzian contact, ``F^(2/3) ~ at - zero``, comes to zero."""
    if len(force) < 5 or float(np.ptp(at)) == 0.0:
        return float(at[0])
    slope, offset = np.polyfit(at, np.maximum(force, 0.0) ** (2.0 / 3.0), 1)
    zero = float(-offset / slope) if slope else float(at[0])
    return zero if abs(zero - float(at[0])) < float(np.ptp(at)) else float(at[0])


def _step(database: Database, name: str) -> float:
    found = database.signal(name)
    return 0.0 if found.is_float else abs(found.scale)
