"""The compiled steps of the virtual hand, all in one file (see :mod:`vegrip.compiled` for why).

They work on records, whose fields the classes of this file name: a :class:`Hand` has all of them, a tip on a
bench is :class:`Contacts` of one.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vegrip.compiled import njit
from vegrip.types import Floats

LOWEST_EXPONENT, HIGHEST_EXPONENT, EXPONENTS = 1.0, 200.0, 400
EXPONENT_RATIO = math.log(HIGHEST_EXPONENT / LOWEST_EXPONENT) / (EXPONENTS - 1)
"""The tables of the pressure are given at ``k_j = LOWEST_EXPONENT e^(EXPONENT_RATIO j)``."""

COURANT = 0.4
"""Greatest phase and damping per substep of the fastest vibration of the plate on its bristles."""

SLIDING = 0.95
"""Ratio of slip speed to speed of the object over the patch from which the patch counts as sliding [-]."""
CREEPING = 1e-3
"""A patch that slips slower than this many contact radii per second is creeping [1/s]."""
DISTANCE = 1e-4
"""A patch that slid less than this in an event was creeping, not slipping [m]."""
SEPARATING_REST_S = 0.05
"""A slip is over when no patch has slid for this long [s]."""

FRICTION_STATED_AT_N = 5.0
"""Normal force of a contact at which its friction is the one that is stated [N]."""

Records = NDArray[Any]


class Tip:
    """One fingertip."""

    # what it is
    side: float  # 1 for the first finger, -1 for those that oppose it
    x: float  # [m] place of the contact
    y: float
    radius: float  # [m]
    d0: float  # [m] N_e = F0 (delta / d0)^p
    p: float
    F0: float  # [N] at the present temperature
    instant: float  # [-] share of an increment of N_e that is felt within the step
    friction: float  # [-] of the dry surface at 5 N
    friction_exponent: float  # [-] by which it falls with the force
    stiffness: float  # [N/m^3] of the bristles
    damping: float  # [s] of them
    C_fresh: float  # [-] pressure coefficient of a contact that has just been made
    # its drive
    position: float  # [m] towards the object
    wanted: float  # [N]
    target: float  # [N] what the force loop follows; NaN = it holds its position
    # its contact
    past: float  # [N] what the past contributes to the force of this step
    before: float  # [N] N_e of the surface
    increment: float  # [N] of it in this step
    force: float  # [N]
    depth: float  # [m] of the imposed position; negative out of contact
    reference: float  # [N] greatest force of this contact
    a: float  # [m] radius
    C: float  # [-] pressure coefficient
    k: float  # [-] and exponent
    mu: float  # [-] at the present force
    # what the object does to it, in the hand's frame
    pull_x: float  # [N]
    pull_y: float
    torque: float  # [N m]
    slip_speed: float  # [m/s] mean over the normal force
    sliding_share: float
    """[-] Slip speed over the speed of the object over the patch: 0 = sticks, 1 = slides everywhere that
    matters (the very middle of a twisted patch hardly moves and does not)."""
    slip_distance: float  # [m] since the start
    slides: float  # 1 for a patch that slides as a whole
    slid: float  # [m] in the present event


class Ring:
    """The elements on one ring of a patch, in the unit disc."""

    reach: float  # where they sit
    area: float  # share of the disc of one of them


class Spoke:
    """The elements on one spoke of a patch."""

    cosine: float
    sine: float


class Channel:
    """A quantity that is sensed."""

    gain: float  # [-] with which it is measured
    step: float  # resolution; 0 = exact
    present: float  # 0 where there is no sensor


class Body:
    """What the fingers share: settings of hand, drives and object, by their names there, and the object."""

    step: float
    initial_force: float
    close_time: float
    lift_time: float
    force_limit: float
    force_rate: float
    stiction: float
    speed: float
    bandwidth: float
    mass: float
    inertia: float
    gravity: float
    drop_distance: float
    drop_angle: float
    z: float  # [m] place of the object along the normals
    x: float  # [m] its pose
    y: float
    angle: float  # [rad]
    vx: float  # [m/s]
    vy: float
    spin: float  # [rad/s]
    start_x: float  # [m]
    start_y: float
    dropped: float  # 1 when it was lost
    slips: float  # so far
    in_event: float  # 1 while patches slide, or did just now
    is_counted: float  # 1 when this event was counted as a slip
    rest: float  # [s] for which none has slid in it
    largest_micro_slip: float  # [m] largest slide of an event that was not counted


def _record(fields: type) -> np.dtype[Any]:
    return np.dtype([(name, float) for name in fields.__annotations__])


TIP, RING, SPOKE, CHANNEL, BODY = map(_record, (Tip, Ring, Spoke, Channel, Body))


class Contacts(NamedTuple):
    """Fingertips and the elements of their patches."""

    tips: Records  # (n,) of TIP
    bristles: Floats  # (n, R, S, 2) [m]
    load: Floats  # (n, R) share of the normal force on one element of each ring
    rings: Records  # (R,) of RING
    spokes: Records  # (S,) of SPOKE


class Memory(NamedTuple):
    """The history of all tips (:mod:`.history`)."""

    recent: Floats  # (n, m) increments of N_e kept one by one
    weights: Floats  # (n, m) of them, the newest last
    older: Floats  # (n,) what the merged blocks contribute now
    newer: Floats  # (n,) and a block later
    sizes: NDArray[np.int64]  # (2,) increments kept one by one, and those of a block


class Hand(NamedTuple):
    """All that moves, and the tables of the pressure profile."""

    body: Records  # (1,) of BODY
    contacts: Contacts
    memory: Memory
    coefficients: Floats  # (EXPONENTS,) -ln(C_k - 1)
    shares: Floats  # (EXPONENTS, R) of the normal force on a ring


@njit
def advance(hand: Hand, tick: int, ticks: int, filled: int, commands: Floats, burdens: Floats) -> None:
    """Advance the whole hand by ``ticks`` steps after step number ``tick``.

    There is room for them in the history, which is ``filled`` so far; ``commands`` are the normal forces
    asked of all fingers [N], NaN = none; ``burdens`` force x, y [N], torque [N m], mass [kg], turn [rad] and
    factor of friction of each step.
    """
    body: Body = hand.body[0]
    tips, memory = hand.contacts.tips, hand.memory
    for step in range(ticks):
        now, full = (tick + step + 1) * body.step, filled + step
        for i in range(len(tips)):
            tips[i].past = past_of(memory, full, i)
        share_forces(tips, commands)
        if body.dropped > 0.0 or now <= body.close_time:
            for i in range(len(tips)):
                tips[i].wanted = math.nan if body.dropped > 0.0 else body.initial_force
        move_drives(body, tips)
        if body.dropped == 0.0:
            body.z = balanced_place(tips, body.z)
        for i in range(len(tips)):
            tip: Tip = tips[i]
            # once it is lost, nothing is between the fingers any more
            press(tip, tip.position + tip.side * body.z if body.dropped == 0.0 else -tip.d0)
            memory.recent[i, full] = tip.increment
            find_contact(tip)
            tip.k = pressure_exponent(tip.C, hand.coefficients)
            tip.mu = friction_of(tip, burdens[step, 5])
        if body.dropped == 0.0:
            hold_object(hand, burdens[step], now)


@njit
def summed_past(memory: Memory, filled: int) -> Floats:
    """Return what all earlier increments contribute to the force of the coming step [N]; (n,)."""
    past = np.empty(len(memory.recent))
    for i in range(len(past)):
        past[i] = past_of(memory, filled, i)
    return past


@njit
def past_of(memory: Memory, filled: int, i: int) -> float:
    """Return the same of tip ``i``, where so many increments are kept one by one.

    Four partial sums: one alone would wait for each addition.
    """
    recent, weights = memory.recent, memory.weights
    first = weights.shape[1] - filled
    a, b, c, d = 0.0, 0.0, 0.0, 0.0
    whole = filled - filled % 4
    for j in range(0, whole, 4):
        a += recent[i, j] * weights[i, first + j]
        b += recent[i, j + 1] * weights[i, first + j + 1]
        c += recent[i, j + 2] * weights[i, first + j + 2]
        d += recent[i, j + 3] * weights[i, first + j + 3]
    for j in range(whole, filled):
        a += recent[i, j] * weights[i, first + j]
    part = max(0.0, (filled - memory.sizes[0]) / memory.sizes[1])  # of a block since the last merge
    older: float = (1.0 - part) * memory.older[i] + part * memory.newer[i]
    return (a + b) + (c + d) + older


@njit
def share_forces(tips: Records, commands: Floats) -> None:
    """Set what is wanted of the opposed fingers, by the commands of all [N], the first finger's included.

    The first finger carries the sum of the others. If it asks for more, all of them give more in proportion
    (or evenly, if they ask for nothing); it can never make them give less. NaN = no valid command.
    """
    first, asked, valid = commands[0], 0.0, 0
    for i in range(1, len(tips)):
        if not math.isnan(commands[i]):
            asked += commands[i]
            valid += 1
    for i in range(1, len(tips)):
        tips[i].wanted = commands[i]
        if first > asked > 0.0:
            tips[i].wanted *= first / asked
        elif first > asked and not math.isnan(commands[i]):
            tips[i].wanted = first / valid


@njit
def move_drives(body: Body, tips: Records) -> None:
    """Move the drives of the opposed fingers by a step, each against its tip and the first one in series."""
    n, first = len(tips), stiffness(tips[0])
    for i in range(1, n):
        move_drive(body, tips[i], 1.0 / (1.0 / stiffness(tips[i]) + (n - 1) / first))


@njit
def stiffness(tip: Tip) -> float:
    """Return the stiffness [N/m] of a tip; in the air that of a light touch."""
    d = max(tip.depth, 0.05 * tip.d0)
    own: float = tip.instant * tip.p * tip.F0 * (d / tip.d0) ** tip.p / d
    return own


@njit
def move_drive(body: Body, tip: Tip, stiffness: float) -> None:
    """Move a drive by a step towards the wanted force; NaN holds the position.

    It tracks the force, limited in rate, with a first-order loop against a ``stiffness`` [N/m]; a force error
    below the stiction moves nothing.
    """
    if math.isnan(tip.wanted):
        tip.target = math.nan
        return
    start = tip.force if math.isnan(tip.target) else tip.target
    change, most = min(max(tip.wanted, 0.0), body.force_limit) - start, body.force_rate * body.step
    tip.target = start + min(max(change, -most), most)
    error = tip.target - tip.force
    pull = error - min(max(error, -body.stiction), body.stiction)
    speed = 2.0 * math.pi * body.bandwidth * pull / stiffness
    if not math.isnan(speed):
        tip.position += body.step * min(max(speed, -body.speed), body.speed)


@njit
def balanced_place(tips: Records, z: float) -> float:
    """Return the place z [m] of the object at which the normal forces of all fingers cancel.

    Finger i is indented by ``x_i + side_i z``; ``sum_i side_i N_i`` grows with z, so Newton's step is kept
    inside the bracket found so far. Where nothing touches, z stays.
    """
    low, high, scale = -math.inf, math.inf, 0.0
    for i in range(len(tips)):
        scale = max(scale, tips[i].d0)
    for _ in range(200):
        residual, slope, total = 0.0, 0.0, 0.0
        for i in range(len(tips)):
            tip: Tip = tips[i]
            d = tip.position + tip.side * z
            N = normal_force(tip, d)
            if N > 0.0 and d > 0.0:
                residual += tip.side * N
                total += N
                slope += tip.instant * tip.p * tip.F0 * (d / tip.d0) ** (tip.p - 1.0) / tip.d0
        if slope == 0.0 or abs(residual) <= 1e-13 * total:
            break
        if residual > 0.0:
            high = z
        else:
            low = z
        there = z + max(-scale, min(scale, -residual / slope))
        if not low < there < high:
            there = 0.5 * (low + high)
        if abs(there - z) <= 1e-15 * scale:
            break
        z = there
    return z


@njit
def normal_force(tip: Tip, depth: float) -> float:
    """Return the force [N] at a depth [m]: ``past + w_0 (N_e(depth) - N_e before)``, never pulling."""
    elastic: float = tip.F0 * (max(depth, 0.0) / tip.d0) ** tip.p
    return max(0.0, tip.past + tip.instant * (elastic - tip.before))


@njit
def press(tip: Tip, depth: float) -> None:
    """Impose an indentation [m] at the end of a step."""
    settle(tip, depth, normal_force(tip, depth))


@njit
def settle(tip: Tip, depth: float, force: float) -> None:
    """Close a step with an indentation [m] and the normal force [N] that belongs to it.

    Where the force would turn negative the surface has left the object: it recovers freely, and the history
    keeps the N_e that gives zero force instead of the one of the imposed displacement.
    """
    tip.increment = (force - tip.past) / tip.instant
    tip.before += tip.increment
    tip.force, tip.depth = force, depth
    tip.reference = max(tip.reference, force) if force > 0.0 else 0.0


@njit
def press_tips(tips: Records, depths: Floats) -> None:
    """Impose indentations [m] on all tips."""
    for i in range(len(tips)):
        press(tips[i], depths[i])


@njit
def settle_tips(tips: Records, depths: Floats, forces: Floats) -> None:
    """Close a step of all tips with indentations [m] and the normal forces [N] that belong to them."""
    for i in range(len(tips)):
        settle(tips[i], depths[i], forces[i])


@njit
def find_contact(tip: Tip) -> None:
    """Set contact radius ``a = sqrt(2 R delta)`` and pressure coefficient, ``C_k = C_2 / H``.

    The creep is ``H = delta / delta_e(N_ref)`` with the greatest force of this contact, so a held indentation
    keeps its profile and a held force flattens it ([TiezziKao2007]_, eq. (36); H is never below one).
    """
    tip.a = math.sqrt(2.0 * tip.radius * max(tip.depth, 0.0)) if tip.force > 0.0 else 0.0
    fresh = tip.d0 * (max(tip.reference, 0.0) / tip.F0) ** (1.0 / tip.p)
    creep = tip.depth / fresh if fresh > 0.0 else 1.0
    tip.C = tip.C_fresh / max(creep, 1.0)


@njit
def friction_of(tip: Tip, factor: float) -> float:
    """Return ``mu(N) = factor friction (N / 5 N)^-g`` at the present force; out of contact that of 5 N."""
    mu = factor * tip.friction
    if tip.force > 0.0:
        mu *= (tip.force / FRICTION_STATED_AT_N) ** -tip.friction_exponent
    return mu


@njit
def pressure_exponent(C: float, coefficients: Floats) -> float:
    """Return the exponent k with the coefficient C; beyond the table its first or last k."""
    wanted = -math.log(max(C - 1.0, 1e-12))
    j = min(max(int(np.searchsorted(coefficients, wanted)) - 1, 0), EXPONENTS - 2)
    part = (wanted - coefficients[j]) / (coefficients[j + 1] - coefficients[j])
    return LOWEST_EXPONENT * math.exp(EXPONENT_RATIO * (j + min(max(part, 0.0), 1.0)))


@njit
def find_exponents(tips: Records, coefficients: Floats) -> None:
    """Find contacts and exponents of all tips."""
    for i in range(len(tips)):
        find_contact(tips[i])
        tips[i].k = pressure_exponent(tips[i].C, coefficients)


@njit
def share_out(k: float, shares: Floats, spokes: int, load: Floats) -> None:
    """Set the share of the normal force on one element of each ring, ``load`` (R,), for an exponent k."""
    last = len(shares) - 1
    place = min(max(math.log(k / LOWEST_EXPONENT) / EXPONENT_RATIO, 0.0), float(last))
    j = min(int(place), last - 1)
    for ring in range(len(load)):
        share = shares[j, ring] + (place - j) * (shares[j + 1, ring] - shares[j, ring])
        load[ring] = share / spokes


@njit
def rub(contacts: Contacts, i: int, vx: float, vy: float, spin: float, dt: float) -> None:
    """Move the object over patch ``i`` for ``dt`` [s], at (vx, vy) [m/s] and ``spin`` [rad/s].

    Every element is a bristle [m] that follows the object with traction ``s q + c q'`` and lets go at ``mu``
    times its share of the normal force (implicit return to Coulomb's limit, so the limit is never exceeded).
    """
    tip: Tip = contacts.tips[i]
    bristle, load, rings, spokes = contacts.bristles[i], contacts.load[i], contacts.rings, contacts.spokes
    fx, fy, torque, speed, passing = 0.0, 0.0, 0.0, 0.0, 0.0
    if tip.force <= 0.0 or tip.a <= 0.0:
        bristle[:] = 0.0
    else:
        patch = math.pi * tip.a * tip.a
        for ring in range(len(rings)):
            s = tip.stiffness * patch * rings[ring].area
            c = s * tip.damping
            limit = tip.mu * tip.force * load[ring]
            rho = tip.a * rings[ring].reach
            for j in range(len(spokes)):
                x, y = rho * spokes[j].cosine, rho * spokes[j].sine
                wx, wy = vx - spin * y, vy + spin * x
                passing += load[ring] * math.sqrt(wx * wx + wy * wy)
                qx, qy = bristle[ring, j, 0], bristle[ring, j, 1]
                nx, ny = qx + wx * dt, qy + wy * dt
                tx, ty = s * nx + c * wx, s * ny + c * wy
                t = math.sqrt(tx * tx + ty * ty)
                if t > limit:
                    tx *= limit / t
                    ty *= limit / t
                    mx, my = (tx + c * qx / dt) / (s + c / dt), (ty + c * qy / dt) / (s + c / dt)
                    speed += load[ring] * math.sqrt((nx - mx) ** 2 + (ny - my) ** 2) / dt
                    nx, ny = mx, my
                bristle[ring, j, 0], bristle[ring, j, 1] = nx, ny
                fx += tx
                fy += ty
                torque += x * ty - y * tx
    tip.pull_x, tip.pull_y, tip.torque = fx, fy, torque
    tip.sliding_share = min(1.0, speed / passing) if passing > 0.0 else 0.0
    tip.slip_speed = speed


@njit
def hold_object(hand: Hand, burden: Floats, now: float) -> None:
    """Carry the object for a step, and see whether it slips or is lost."""
    body: Body = hand.body[0]
    contacts, tips = hand.contacts, hand.contacts.tips
    gone = now - body.close_time
    stand = 1.0 if gone <= 0.0 else 0.0  # share of the weight on it
    if body.lift_time > 0.0:
        stand = min(max(1.0 - gone / body.lift_time, 0.0), 1.0)
    mass = body.mass + burden[3]
    weight = (1.0 - stand) * mass * body.gravity
    fx, fy = burden[0] + weight * math.sin(burden[4]), burden[1] - weight * math.cos(burden[4])
    for i in range(len(tips)):
        share_out(tips[i].k, hand.shares, len(contacts.spokes), contacts.load[i])
    carry(body, contacts, mass, fx, fy, burden[2])
    watch_slips(body, tips)
    x, y = body.x - body.start_x, body.y - body.start_y
    if math.hypot(x, y) > body.drop_distance or abs(body.angle) > body.drop_angle:
        body.dropped = 1.0
        for i in range(len(tips)):
            tips[i].pull_x, tips[i].pull_y, tips[i].torque = 0.0, 0.0, 0.0
            tips[i].sliding_share, tips[i].slip_speed, tips[i].slides = 0.0, 0.0, 0.0


@njit
def carry(body: Body, contacts: Contacts, mass: float, force_x: float, force_y: float, torque: float) -> None:
    """Move the object by a step under force and torque from outside; symplectic Euler, forces from rub."""
    parts = substeps(body, contacts.tips, mass)
    dt = body.step / parts
    for _ in range(parts):
        fx, fy, turning = force_x, force_y, torque
        for i in range(len(contacts.tips)):
            tip: Tip = contacts.tips[i]
            lx, ly = tip.x - body.x, tip.y - body.y
            rub(contacts, i, body.vx - body.spin * ly, body.vy + body.spin * lx, body.spin, dt)
            tip.slip_distance += tip.slip_speed * dt
            fx -= tip.pull_x
            fy -= tip.pull_y
            turning -= tip.torque + lx * tip.pull_y - ly * tip.pull_x
        body.vx += dt * fx / mass
        body.vy += dt * fy / mass
        body.spin += dt * turning / body.inertia
        body.x += dt * body.vx
        body.y += dt * body.vy
        body.angle += dt * body.spin


@njit
def substeps(body: Body, tips: Records, mass: float) -> int:
    """Return how finely to divide a step so that the explicit scheme is far inside its stability limit."""
    push, turn, push_damped, turn_damped = 0.0, 0.0, 0.0, 0.0
    for i in range(len(tips)):
        tip: Tip = tips[i]
        s = tip.stiffness * math.pi * tip.a * tip.a
        lx, ly = tip.x - body.x, tip.y - body.y
        turning = s * (lx * lx + ly * ly + 0.5 * tip.a * tip.a) / body.inertia
        push += s / mass
        turn += turning
        push_damped += s / mass * tip.damping
        turn_damped += turning * tip.damping
    square = max(push, turn)  # of the greatest angular frequency
    viscous = max(push_damped, turn_damped)
    return max(1, math.ceil(body.step * max(math.sqrt(square), viscous) / COURANT))


@njit
def slides_whole(tip: Tip) -> bool:
    """Return whether a patch slides as a whole."""
    return tip.sliding_share > SLIDING and tip.slip_speed > CREEPING * tip.a


@njit
def watch_slips(body: Body, tips: Records) -> None:
    """Note which patches slide as a whole in this step, and count the slips.

    Patches that slide within :data:`SEPARATING_REST_S` are one slip.
    """
    some, furthest = False, 0.0
    for i in range(len(tips)):
        tips[i].slides = 1.0 if slides_whole(tips[i]) else 0.0
        some = some or tips[i].slides > 0.0
    if some and body.in_event == 0.0:
        body.in_event, body.is_counted = 1.0, 0.0
        for i in range(len(tips)):
            tips[i].slid = 0.0
    for i in range(len(tips)):
        tips[i].slid += tips[i].slip_speed * body.step * tips[i].slides
        furthest = max(furthest, tips[i].slid)
    if some:
        body.rest = 0.0
        if body.is_counted == 0.0 and furthest > DISTANCE:
            body.is_counted = 1.0
            body.slips += 1.0
    elif body.in_event > 0.0:
        body.rest += body.step
        if body.rest >= SEPARATING_REST_S:
            end_event(body, tips)


@njit
def end_event(body: Body, tips: Records) -> None:
    """End the present event, if there is one; a slide that does not count as a slip is a micro-slip."""
    if body.in_event > 0.0 and body.is_counted == 0.0:
        for i in range(len(tips)):
            body.largest_micro_slip = max(body.largest_micro_slip, tips[i].slid)
    body.in_event = 0.0


@njit
def sense(
    tips: Records, temperature: float, threshold: float, felt: Floats, number: int, errors: Floats,
    channels: Records,
) -> Floats:  # fmt: skip
    """Return what is sensed of the tips in their contact frames: with errors, in steps, NaN without a sensor.

    Slip is reported from a ``threshold`` of its speed [m/s] on, and late: ``felt`` (delay + 1, n, 2) keeps
    flag and speed of as many samples, in turn, and ``number`` is that of this one from 0. ``errors`` (n, 8)
    and ``channels`` are those of the measured quantities; the slip flag stands before the last two: (n, 9).
    """
    sensed = np.empty((len(tips), 9))
    place, late = number % len(felt), (number + 1) % len(felt)
    for i in range(len(tips)):
        tip: Tip = tips[i]
        slips = tip.slip_speed >= threshold
        felt[place, i, 0] = tip.slides if slips else 0.0
        felt[place, i, 1] = tip.slip_speed if slips else 0.0
        true = (
            tip.force, -tip.side * tip.pull_x, tip.pull_y, -tip.side * tip.torque, tip.depth, temperature,
            felt[late, i, 1], tip.a,
        )  # fmt: skip
        for j in range(8):
            value = channels[j].gain * true[j] + errors[i, j]
            if channels[j].step > 0.0:
                value = round(value / channels[j].step) * channels[j].step
            if j >= 6:  # a magnitude
                value = max(value, 0.0)
            sensed[i, j if j < 6 else j + 1] = value if channels[j].present > 0.0 else math.nan
        sensed[i, 6] = felt[late, i, 0] if channels[6].present > 0.0 else math.nan
    return sensed


@njit
def limit_point(load: Floats, rings: Records, spokes: Records, d: float) -> tuple[float, float]:
    """Return |f|/(mu N) and |m|/(mu N a) when all elements slide about a centre at distance ``d`` [a]."""
    f, m = 0.0, 0.0
    for i in range(len(rings)):
        for j in range(len(spokes)):
            x, y = rings[i].reach * spokes[j].cosine, rings[i].reach * spokes[j].sine
            rho = math.sqrt((x - d) ** 2 + y * y)
            if rho > 0.0:
                f -= load[i] * (x - d) / rho
                m += load[i] * (x * (x - d) + y * y) / rho
    return f, m


@njit
def limit_along(load: Floats, rings: Records, spokes: Records, f: float, m: float) -> float:
    """Return the distance from the origin to the limit surface along the load (f/(mu N), m/(mu N a)).

    The centre of rotation lies between the middle of the patch and infinity, d = part / (1 - part); the
    direction of the limit load turns from pure torque to pure force on the way. The part is found by false
    position with Illinois weights, and by bisection where that leaves the bracket or does not halve it in
    three steps.
    """
    low, high = 0.0, 1.0  # of d / (1 + d)
    there_f, there_m = limit_point(load, rings, spokes, 0.0)
    below = there_f * m - there_m * f  # too much torque: the centre lies further out
    above = load.sum() * len(spokes) * m  # a centre at infinity: force alone
    radius, before, last, steps, part = 1.0, 1.0, 0, 0, 0.0
    for _ in range(120):
        previous, part = part, 0.5 * (low + high)
        if steps < 3 and above > below:
            secant = high - above * (high - low) / (above - below)
            if low < secant < high:
                part = secant
        there_f, there_m = limit_point(load, rings, spokes, part / (1.0 - part))
        radius = math.hypot(there_f, there_m)
        turn = there_f * m - there_m * f
        if turn < 0.0:
            low, below = part, turn
            above *= 0.5 if last < 0 else 1.0
            last = -1
        else:
            high, above = part, turn
            below *= 0.5 if last > 0 else 1.0
            last = 1
        steps += 1
        if high - low < 0.5 * before:
            before, steps = high - low, 0
        if high - low < 1e-12 or abs(part - previous) < 1e-13 or turn == 0.0:
            break
    return radius


@njit
def true_contacts(contacts: Contacts, shares: Floats) -> Floats:
    """Return what is really the case at all contacts, (n, 14): the fields of FingerTruth, in its order."""
    tips, load = contacts.tips, contacts.load
    truth = np.empty((len(tips), 14))
    for i in range(len(tips)):
        tip: Tip = tips[i]
        share_out(tip.k, shares, len(contacts.spokes), load[i])
        fx, fy, torque = -tip.side * tip.pull_x, tip.pull_y, -tip.side * tip.torque
        most, along = tip.mu * tip.force, math.hypot(fx, fy)
        used, size = 0.0, 0.0
        if tip.force > 0.0 and tip.a > 0.0:
            f, m = along / most, torque / (most * tip.a)
            size = math.hypot(f, m)
            if size > 0.0:
                used = size / limit_along(load[i], contacts.rings, contacts.spokes, abs(f), abs(m))
        radius = math.hypot(along, torque / tip.a) / used if used > 0.0 else most
        truth[i, 0], truth[i, 1], truth[i, 2], truth[i, 3] = tip.force, tip.depth, tip.a, tip.k
        truth[i, 4], truth[i, 5], truth[i, 6], truth[i, 7] = tip.mu, fx, fy, torque
        truth[i, 8], truth[i, 9], truth[i, 10] = used, radius, tip.slides
        truth[i, 11], truth[i, 12], truth[i, 13] = tip.sliding_share, tip.slip_speed, tip.slip_distance
    return truth
