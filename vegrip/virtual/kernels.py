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
