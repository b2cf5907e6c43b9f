"""The compiled loops of the virtual hand, all in one file (see :mod:`vegrip.compiled` for why).

Arrays: n fingers, R rings of S elements in the unit disc. ``load`` is the share of the normal force on one
element of each ring (n, R), ``area`` the share of the contact area of one element (R,), ``reach`` the radius
of each ring in the unit disc (R,), ``cosine`` and ``sine`` of the spokes (S,).
"""

import math

import numpy as np

from vegrip.compiled import njit
from vegrip.types import Floats


@njit
def pressure_exponents(C: Floats, table: Floats, first: float, ratio: float) -> Floats:
    """Return the exponents k with coefficients C; ``table`` is -ln(C_k - 1) at k = first e^(ratio j)."""
    k = np.empty(len(C))
    last = len(table) - 1
    for i in range(len(C)):
        wanted = -math.log(max(C[i] - 1.0, 1e-12))
        j = min(max(int(np.searchsorted(table, wanted)) - 1, 0), last - 1)
        part = (wanted - table[j]) / (table[j + 1] - table[j])
        k[i] = first * math.exp(ratio * (j + min(max(part, 0.0), 1.0)))
    return k


@njit
def ring_loads(k: Floats, table: Floats, first: float, ratio: float) -> Floats:
    """Return rows of ``table`` (400, R) interpolated in ln k; they are given at k = first e^(ratio j)."""
    load = np.empty((len(k), table.shape[1]))
    last = len(table) - 1
    for i in range(len(k)):
        place = min(max(math.log(k[i] / first) / ratio, 0.0), float(last))
        j = min(int(place), last - 1)
        for ring in range(table.shape[1]):
            load[i, ring] = table[j, ring] + (place - j) * (table[j + 1, ring] - table[j, ring])
    return load


@njit
def normal_force(
    past: float, instant: float, before: float, F0: float, d0: float, p: float, d: float
) -> float:
    """Return the force [N] at indentation d: ``past + w_0 (N_e(d) - N_e before)``, never pulling."""
    Ne: float = F0 * (max(d, 0.0) / d0) ** p
    return max(0.0, past + instant * (Ne - before))


@njit
def balance(
    x: Floats,
    side: Floats,
    past: Floats,
    instant: Floats,
    before: Floats,
    F0: Floats,
    d0: Floats,
    p: Floats,
    z: float,
) -> float:
    """Return the place z [m] of the object at which the normal forces of all fingers cancel.

    Finger i is indented by ``x_i + side_i z``; ``sum_i side_i N_i`` grows with z, so Newton's step is kept
    inside the bracket found so far. Where nothing touches, z stays.
    """
    low, high = -math.inf, math.inf
    scale = d0.max()
    for _ in range(200):
        residual, slope, total = 0.0, 0.0, 0.0
        for i in range(len(x)):
            d = x[i] + side[i] * z
            N = normal_force(past[i], instant[i], before[i], F0[i], d0[i], p[i], d)
            if N > 0.0 and d > 0.0:
                residual += side[i] * N
                total += N
                slope += instant[i] * p[i] * F0[i] * (d / d0[i]) ** (p[i] - 1.0) / d0[i]
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
def rub(
    bristle: Floats,
    load: Floats,
    area: Floats,
    reach: Floats,
    cosine: Floats,
    sine: Floats,
    a: float,
    N: float,
    mu: float,
    stiffness: float,
    damping: float,
    vx: float,
    vy: float,
    spin: float,
    dt: float,
) -> tuple[float, float, float, float, float]:
    """Move the object over one patch for ``dt`` [s]; return force x, y, torque, sliding, slip speed.

    Every element is a bristle (R, S, 2) [m] that follows the object at (vx, vy) [m/s] and ``spin`` [rad/s]
    with traction ``s q + c q'`` and lets go at ``mu`` times its share of the normal force (implicit return to
    Coulomb's limit, so the limit is never exceeded). Slip speed is the mean over the normal force [m/s];
    sliding its ratio to the mean speed of the object over the patch, 0 = sticks, 1 = slides everywhere that
    matters (the very middle of a twisted patch hardly moves and does not).
    """
    fx, fy, torque, speed, passing = 0.0, 0.0, 0.0, 0.0, 0.0
    if N <= 0.0 or a <= 0.0:
        bristle[:] = 0.0
        return fx, fy, torque, 0.0, 0.0
    patch = math.pi * a * a
    for i in range(len(reach)):
        s = stiffness * patch * area[i]
        c = s * damping
        limit = mu * N * load[i]
        rho = a * reach[i]
        for j in range(len(cosine)):
            x, y = rho * cosine[j], rho * sine[j]
            wx, wy = vx - spin * y, vy + spin * x
            passing += load[i] * math.sqrt(wx * wx + wy * wy)
            qx, qy = bristle[i, j, 0], bristle[i, j, 1]
            nx, ny = qx + wx * dt, qy + wy * dt
            tx, ty = s * nx + c * wx, s * ny + c * wy
            t = math.sqrt(tx * tx + ty * ty)
            if t > limit:
                tx *= limit / t
                ty *= limit / t
                mx, my = (tx + c * qx / dt) / (s + c / dt), (ty + c * qy / dt) / (s + c / dt)
                speed += load[i] * math.sqrt((nx - mx) ** 2 + (ny - my) ** 2) / dt
                nx, ny = mx, my
            bristle[i, j, 0], bristle[i, j, 1] = nx, ny
            fx += tx
            fy += ty
            torque += x * ty - y * tx
    return fx, fy, torque, min(1.0, speed / passing) if passing > 0.0 else 0.0, speed


@njit
def carry(
    pose: Floats,
    bristle: Floats,
    wrench: Floats,
    slip: Floats,
    load: Floats,
    area: Floats,
    reach: Floats,
    cosine: Floats,
    sine: Floats,
    a: Floats,
    N: Floats,
    mu: Floats,
    stiffness: Floats,
    damping: Floats,
    place: Floats,
    mass: float,
    inertia: float,
    applied: Floats,
    substeps: int,
    dt: float,
) -> None:
    """Move the held object by ``substeps`` of ``dt`` [s]; symplectic Euler, forces from :func:`rub`.

    ``pose`` is x, y, angle of the centre of mass and their rates (6,); ``place`` the contacts (n, 2);
    ``applied`` force and torque from outside (3,). Returns in place: pose, bristle (n, R, S, 2), ``wrench``
    of the object on each finger (n, 3), ``slip`` = sliding, slip speed, slid distance (n, 3).
    """
    for _ in range(substeps):
        fx, fy, torque = applied[0], applied[1], applied[2]
        for i in range(len(N)):
            lx, ly = place[i, 0] - pose[0], place[i, 1] - pose[1]
            tx, ty, m, sliding, speed = rub(
                bristle[i], load[i], area, reach, cosine, sine, a[i], N[i], mu[i], stiffness[i], damping[i],
                pose[3] - pose[5] * ly, pose[4] + pose[5] * lx, pose[5], dt,
            )  # fmt: skip
            wrench[i, 0], wrench[i, 1], wrench[i, 2] = tx, ty, m
            slip[i, 0], slip[i, 1] = sliding, speed
            slip[i, 2] += speed * dt
            fx -= tx
            fy -= ty
            torque -= m + lx * ty - ly * tx
        pose[3] += dt * fx / mass
        pose[4] += dt * fy / mass
        pose[5] += dt * torque / inertia
        for k in range(3):
            pose[k] += dt * pose[3 + k]


@njit
def substeps_of(
    pose: Floats, place: Floats, a: Floats, stiffness: Floats, damping: Floats,
    mass: float, inertia: float, courant: float, dt: float,
) -> int:  # fmt: skip
    """Return how finely to divide a step so that the explicit scheme is far inside its stability limit."""
    push, turn, push_damped, turn_damped = 0.0, 0.0, 0.0, 0.0
    for i in range(len(a)):
        s = stiffness[i] * math.pi * a[i] * a[i]
        lx, ly = place[i, 0] - pose[0], place[i, 1] - pose[1]
        turning = s * (lx * lx + ly * ly + 0.5 * a[i] * a[i]) / inertia
        push += s / mass
        turn += turning
        push_damped += s / mass * damping[i]
        turn_damped += turning * damping[i]
    square = max(push, turn)  # of the greatest angular frequency
    viscous = max(push_damped, turn_damped)
    return max(1, math.ceil(dt * max(math.sqrt(square), viscous) / courant))


@njit
def share_forces(commands: Floats) -> Floats:
    """Return the forces of the opposed fingers [N] from the commands of all, the first finger's included.

    The first finger carries the sum of the others. If it asks for more, all of them give more in proportion
    (or evenly, if they ask for nothing); it can never make them give less. NaN = no valid command.
    """
    first, others = commands[0], commands[1:].copy()
    asked, valid = 0.0, 0
    for force in others:
        if not math.isnan(force):
            asked += force
            valid += 1
    if first > asked:
        for i in range(len(others)):
            if asked > 0.0:
                others[i] *= first / asked
            elif not math.isnan(others[i]):
                others[i] = first / max(1, valid)
    return others


@njit
def move_drives(
    position: Floats, target: Floats, limits: Floats, wanted: Floats, force: Floats, stiffness: Floats,
    dt: float,
) -> None:  # fmt: skip
    """Move drives for ``dt`` [s] towards the ``wanted`` forces [N]; NaN holds the position.

    ``force`` [N] and ``stiffness`` [N/m] are those of the contacts now; ``limits`` the greatest force [N],
    the fastest change of it [N/s], stiction [N], fastest motion [m/s] and bandwidth [Hz]. Returns in place:
    position [m] and ``target`` [N].
    """
    most, rate, stiction, fastest, bandwidth = limits[0], limits[1], limits[2], limits[3], limits[4]
    for i in range(len(position)):
        if math.isnan(wanted[i]):
            target[i] = math.nan
            continue
        start = force[i] if math.isnan(target[i]) else target[i]
        change = min(max(wanted[i], 0.0), most) - start
        target[i] = start + min(max(change, -rate * dt), rate * dt)
        error = target[i] - force[i]
        pull = error - min(max(error, -stiction), stiction)
        speed = 2.0 * math.pi * bandwidth * pull / stiffness[i]
        if not math.isnan(speed):
            position[i] += dt * min(max(speed, -fastest), fastest)


@njit
def chain_stiffness(
    depth: Floats, instant: Floats, F0: Floats, d0: Floats, p: Floats
) -> Floats:  # fmt: skip
    """Return the stiffness [N/m] each drive works against when all move: its tip and the first in series."""
    n = len(depth)
    own = np.empty(n)
    for i in range(n):
        d = max(depth[i], 0.05 * d0[i])
        own[i] = instant[i] * p[i] * F0[i] * (d / d0[i]) ** p[i] / d
    chain = np.empty(n - 1)
    for i in range(1, n):
        chain[i - 1] = 1.0 / (1.0 / own[i] + (n - 1) / own[0])
    return chain


@njit
def fresh_past(recent: Floats, reversed_weights: Floats, filled: int, i: int) -> float:
    """Return what the increments of finger ``i`` that are kept one by one contribute [N].

    Four partial sums: one alone would wait for each addition.
    """
    first = reversed_weights.shape[1] - filled
    a, b, c, d = 0.0, 0.0, 0.0, 0.0
    whole = filled - filled % 4
    for j in range(0, whole, 4):
        a += recent[i, j] * reversed_weights[i, first + j]
        b += recent[i, j + 1] * reversed_weights[i, first + j + 1]
        c += recent[i, j + 2] * reversed_weights[i, first + j + 2]
        d += recent[i, j + 3] * reversed_weights[i, first + j + 3]
    for j in range(whole, filled):
        a += recent[i, j] * reversed_weights[i, first + j]
    return (a + b) + (c + d)


@njit
def press_tips(
    depth: Floats, past: Floats, instant: Floats, F0: Floats, d0: Floats, p: Floats,
    before: Floats, force: Floats, reference: Floats, increment: Floats,
) -> None:  # fmt: skip
    """Impose indentations [m] on all tips, as :meth:`vegrip.virtual.fingertip.Fingertips.press` does.

    Returns in place: ``before`` (N_e of the surface), ``force``, ``reference`` (greatest force of this
    contact) and ``increment`` (of N_e in this step), all [N].
    """
    for i in range(len(depth)):
        force[i] = normal_force(past[i], instant[i], before[i], F0[i], d0[i], p[i], depth[i])
        surface = before[i] + (force[i] - past[i]) / instant[i]  # the N_e that gives this force
        increment[i] = surface - before[i]
        before[i] = surface
        reference[i] = max(reference[i], force[i]) if force[i] > 0.0 else 0.0


@njit
def find_contacts(
    depth: Floats, force: Floats, reference: Floats, radius: Floats, F0: Floats, d0: Floats, p: Floats,
    fresh_coefficient: float, a: Floats, C: Floats,
) -> None:  # fmt: skip
    """Return in place the contact radii ``a`` [m] and pressure coefficients ``C`` [-] of all tips."""
    for i in range(len(depth)):
        a[i] = math.sqrt(2.0 * radius[i] * max(depth[i], 0.0)) if force[i] > 0.0 else 0.0
        fresh = d0[i] * (max(reference[i], 0.0) / F0[i]) ** (1.0 / p[i])
        creep = depth[i] / fresh if fresh > 0.0 else 1.0
        C[i] = fresh_coefficient / max(creep, 1.0)


@njit
def watch_slips(
    slip: Floats, a: Floats, sliding: Floats, slid: Floats, count: Floats, constants: Floats, dt: float
) -> None:
    """Note which patches slide as a whole, and count the slips; in place: ``sliding``, ``slid``, ``count``.

    ``count`` holds the slips so far, whether an event is open and counted, for how long [s] none has slid, and
    how far one slid at most in an event that does not count [m]; ``slid`` how far each patch went in the event
    [m]. ``constants`` are those of
    :mod:`vegrip.virtual.slips`, in its order.
    """
    whole, creeping, distance, rest = constants[0], constants[1], constants[2], constants[3]
    some = False
    for i in range(len(a)):
        slides = slip[i, 0] > whole and slip[i, 1] > creeping * a[i]
        sliding[i] = 1.0 if slides else 0.0
        some = some or slides
    if some:
        if count[1] == 0.0:
            count[1], count[2] = 1.0, 0.0
            slid[:] = 0.0
        count[3] = 0.0
        for i in range(len(a)):
            slid[i] += slip[i, 1] * dt * sliding[i]
        if count[2] == 0.0 and slid.max() > distance:
            count[2] = 1.0
            count[0] += 1.0
    elif count[1] > 0.0:
        count[3] += dt
        if count[3] >= rest:
            count[1] = 0.0
            if count[2] == 0.0:
                count[4] = max(count[4], slid.max())


@njit
def hand_ticks(
    ticks: int, tick: int, dt: float, closing: Floats, commands: Floats, burdens: Floats, state: Floats,
    side: Floats, radius: Floats, d0: Floats, p: Floats, F0: Floats, friction: Floats,
    depth: Floats, force: Floats, before: Floats, reference: Floats, mu: Floats, a: Floats, k: Floats,
    position: Floats, target: Floats, limits: Floats,
    recent: Floats, reversed_weights: Floats, instant: Floats, older: Floats, newer: Floats, filled: int,
    fine: int, block: int,
    pose: Floats, start: Floats, bristle: Floats, wrench: Floats, slip: Floats, place: Floats,
    stiffness: Floats, damping: Floats, plate: Floats,
    sliding: Floats, slid: Floats, count: Floats, slips: Floats,
    area: Floats, reach: Floats, cosine: Floats, sine: Floats,
    exponents: Floats, rings: Floats, first: float, ratio: float, fresh_coefficient: float,
) -> None:  # fmt: skip
    """Advance the whole hand by ``ticks`` steps of ``dt`` [s] after step number ``tick``; all in place.

    * ``ticks``: no more than there is room for in ``recent``; ``tick``: number of steps so far;
    * ``closing``: force [N] and time [s] of closing, time of lifting [s]; ``commands``: normal forces asked
      of all fingers [N], NaN = none; ``burdens``: force x, y [N], torque [N m], mass [kg], turn [rad] and
      factor of friction of each step;
    * ``state``: place of the object along the normals [m], 1 when it was dropped; ``side``: 1 for the first
      finger, -1 for the opposed ones;
    * ``radius`` to ``friction``: of the tips; ``depth`` to ``k``: of the contacts, as in Fingertips;
    * ``position`` to ``limits``: of the drives, see :func:`move_drives`;
    * ``recent`` to ``block``: the history, see :meth:`~vegrip.virtual.history.History.past`; ``older`` and
      ``newer`` are what the merged blocks contribute now and a block later;
    * ``pose`` to ``damping``: of the plate, see :func:`carry`; ``plate``: mass, inertia, gravity, distance
      and angle at which it is lost, Courant number;
    * ``sliding`` to ``slips``: see :func:`watch_slips`, its constants last;
    * ``area`` to ``sine``: of the patch; the rest: tables of the pressure profile.
    """
    n = len(depth)
    past, increment, C, applied = np.empty(n), np.empty(n), np.empty(n), np.empty(3)
    for step in range(ticks):
        now, full = (tick + step + 1) * dt, filled + step
        part = max(0.0, (full - fine) / block)  # of a block since the last merge
        for i in range(n):
            past[i] = fresh_past(recent, reversed_weights, full, i)
            past[i] += (1.0 - part) * older[i] + part * newer[i]
        wanted = share_forces(commands)
        if state[1] > 0.0:
            wanted[:] = math.nan
        elif now <= closing[1]:
            wanted[:] = closing[0]
        chain = chain_stiffness(depth, instant, F0, d0, p)
        move_drives(position, target, limits, wanted, force[1:], chain, dt)
        depth[0], depth[1:] = 0.0, position
        if state[1] > 0.0:
            depth[:] = -d0  # nothing is between the fingers any more
        else:
            state[0] = balance(depth, side, past, instant, before, F0, d0, p, state[0])
            depth += side * state[0]
        press_tips(depth, past, instant, F0, d0, p, before, force, reference, increment)
        recent[:, full] = increment
        find_contacts(depth, force, reference, radius, F0, d0, p, fresh_coefficient, a, C)
        k[:] = pressure_exponents(C, exponents, first, ratio)
        mu[:] = burdens[step, 5] * friction
        if state[1] > 0.0:
            continue
        gone = now - closing[1]
        stand = (
            min(max(1.0 - gone / closing[2], 0.0), 1.0) if closing[2] > 0.0 else (1.0 if gone <= 0.0 else 0.0)
        )
        mass = plate[0] + burdens[step, 3]
        weight = (1.0 - stand) * mass * plate[2]
        applied[0] = burdens[step, 0] + weight * math.sin(burdens[step, 4])
        applied[1] = burdens[step, 1] - weight * math.cos(burdens[step, 4])
        applied[2] = burdens[step, 2]
        load = ring_loads(k, rings, first, ratio) / len(cosine)
        parts = substeps_of(pose, place, a, stiffness, damping, mass, plate[1], plate[5], dt)
        carry(
            pose, bristle, wrench, slip, load, area, reach, cosine, sine, a, force, mu, stiffness, damping,
            place, mass, plate[1], applied, parts, dt / parts,
        )  # fmt: skip
        watch_slips(slip, a, sliding, slid, count, slips, dt)
        far = math.hypot(pose[0] - start[0], pose[1] - start[1]) > plate[3]
        if far or abs(pose[2] - start[2]) > plate[4]:
            state[1] = 1.0
            sliding[:] = 0.0
            wrench[:] = 0.0
            slip[:, :2] = 0.0


@njit
def sense(
    values: Floats, slides: Floats, threshold: float, felt: Floats, number: int, errors: Floats,
    step: Floats, present: Floats,
) -> Floats:  # fmt: skip
    """Return what is sensed of the true ``values`` (n, 8): with errors, in steps, NaN without a sensor.

    Slip is told from a ``threshold`` of its speed [m/s] on, and late: ``felt`` (delay + 1, n, 2) keeps flag
    and speed of as many samples, in turn, and ``number`` is that of this one from 0. ``step`` is the
    resolution of each quantity, 0 = exact; ``present`` 0 for a quantity without a sensor. The last two are
    magnitudes. The slip flag stands before them: (n, 9).
    """
    sensed = np.empty((values.shape[0], 9))
    place, late = number % len(felt), (number + 1) % len(felt)
    for i in range(values.shape[0]):
        slips = values[i, 6] >= threshold
        felt[place, i, 0] = slides[i] if slips else 0.0
        felt[place, i, 1] = values[i, 6] if slips else 0.0
        for j in range(8):
            value = (felt[late, i, 1] if j == 6 else values[i, j]) + errors[i, j]
            if step[j] > 0.0:
                value = round(value / step[j]) * step[j]
            if j >= 6:
                value = max(value, 0.0)
            sensed[i, j if j < 6 else j + 1] = value if present[j] > 0.0 else math.nan
        sensed[i, 6] = felt[late, i, 0] if present[6] > 0.0 else math.nan
    return sensed


@njit
def read_tips(
    force: Floats, wrench: Floats, turned: Floats, depth: Floats, temperature: float, slip: Floats, a: Floats
) -> Floats:
    """Return the true quantities of all fingers (n, 8) in the order of the sensors.

    ``wrench`` on the tips (n, 3) in the hand's frame, ``turned`` its signs in the contact frames; ``slip``
    has the slip speed in its second column.
    """
    values = np.empty((len(force), 8))
    for i in range(len(force)):
        values[i, 0] = force[i]
        for j in range(3):
            values[i, 1 + j] = turned[i, j] * wrench[i, j]
        values[i, 4], values[i, 5], values[i, 6], values[i, 7] = depth[i], temperature, slip[i, 1], a[i]
    return values


@njit
def sense_tips(
    force: Floats, wrench: Floats, turned: Floats, depth: Floats, temperature: float, slip: Floats, a: Floats,
    slides: Floats, threshold: float, felt: Floats, number: int, errors: Floats, step: Floats,
    present: Floats,
) -> Floats:  # fmt: skip
    """Return what is sensed of the tips, (n, 9): :func:`sense` of :func:`read_tips`."""
    values = read_tips(force, wrench, turned, depth, temperature, slip, a)
    return sense(values, slides, threshold, felt, number, errors, step, present)


@njit
def limit_point(load: Floats, reach: Floats, cosine: Floats, sine: Floats, d: float) -> tuple[float, float]:
    """Return |f|/(mu N) and |m|/(mu N a) when all elements slide about a centre at distance ``d`` [a]."""
    f, m = 0.0, 0.0
    for i in range(len(reach)):
        for j in range(len(cosine)):
            x, y = reach[i] * cosine[j], reach[i] * sine[j]
            rho = math.sqrt((x - d) ** 2 + y * y)
            if rho > 0.0:
                f -= load[i] * (x - d) / rho
                m += load[i] * (x * (x - d) + y * y) / rho
    return f, m


@njit
def limit_along(load: Floats, reach: Floats, cosine: Floats, sine: Floats, f: float, m: float) -> float:
    """Return the distance from the origin to the limit surface along the load (f/(mu N), m/(mu N a)).

    The centre of rotation lies between the middle of the patch and infinity, d = part / (1 - part); the
    direction of the limit load turns from pure torque to pure force on the way. The part is found by false
    position with Illinois weights, and by bisection where that leaves the bracket or does not halve it in
    three steps.
    """
    low, high = 0.0, 1.0  # of d / (1 + d)
    there_f, there_m = limit_point(load, reach, cosine, sine, 0.0)
    below = there_f * m - there_m * f  # too much torque: the centre lies further out
    above = load.sum() * len(cosine) * m  # a centre at infinity: force alone
    radius, before, last, steps, part = 1.0, 1.0, 0, 0, 0.0
    for _ in range(120):
        previous, part = part, 0.5 * (low + high)
        if steps < 3 and above > below:
            secant = high - above * (high - low) / (above - below)
            if low < secant < high:
                part = secant
        there_f, there_m = limit_point(load, reach, cosine, sine, part / (1.0 - part))
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
def true_contacts(
    force: Floats, wrench: Floats, turned: Floats, depth: Floats, a: Floats, k: Floats, mu: Floats,
    slip: Floats, sliding: Floats, reach: Floats, cosine: Floats, sine: Floats,
    rings: Floats, first: float, ratio: float,
) -> Floats:  # fmt: skip
    """Return what is really the case at all contacts, (n, 14): the fields of FingerTruth, in its order.

    ``wrench`` (n, 3) on the tips in the hand's frame, ``turned`` its signs in the contact frames; ``slip``
    and ``sliding`` as :func:`carry` and :func:`watch_slips` give them; ``rings`` to ``ratio``: the table of
    :func:`ring_loads`.
    """
    truth = np.empty((len(force), 14))
    load = ring_loads(k, rings, first, ratio) / len(cosine)
    for i in range(len(force)):
        fx, fy, torque = turned[i, 0] * wrench[i, 0], turned[i, 1] * wrench[i, 1], turned[i, 2] * wrench[i, 2]
        most, along = mu[i] * force[i], math.hypot(fx, fy)
        used, size = 0.0, 0.0
        if force[i] > 0.0 and a[i] > 0.0:
            f, m = along / most, torque / (most * a[i])
            size = math.hypot(f, m)
            if size > 0.0:
                used = size / limit_along(load[i], reach, cosine, sine, abs(f), abs(m))
        radius = math.hypot(along, torque / a[i]) / used if used > 0.0 else most
        truth[i, 0], truth[i, 1], truth[i, 2], truth[i, 3] = force[i], depth[i], a[i], k[i]
        truth[i, 4], truth[i, 5], truth[i, 6], truth[i, 7] = mu[i], fx, fy, torque
        truth[i, 8], truth[i, 9], truth[i, 10] = used, radius, sliding[i]
        truth[i, 11], truth[i, 12], truth[i, 13] = slip[i, 0], slip[i, 1], slip[i, 2]
    return truth
