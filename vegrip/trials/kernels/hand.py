"""One step of the simulated hand: :class:`vegrip.virtual.VirtualHand` over one flat array.

The relaxing forces are followed by their exact recursion instead of the sum over the history: for
``g = 1 - sum c_i (1 - exp(-nu_i t))`` and an elastic force that is linear within steps of h,

    ``q_i <- exp(-nu_i h) (q_i + dN_e)``,   ``N = (1 - sum c_i) sum dN_e + sum c_i phi_i q_i``,
    ``phi_i = (1 - exp(-nu_i h)) / (nu_i h)`` .
"""

import math

from vegrip.trials.kernels.generated import (
    H_ANGLE_LOST,
    H_AREA,
    H_BANDWIDTH,
    H_BEFORE,
    H_BRANCH_DECAY,
    H_BRANCH_SHARE,
    H_BRANCHES,
    H_BRISTLE,
    H_CLOSE_TIME,
    H_COMMAND,
    H_COSINE,
    H_COUNTED,
    H_D0,
    H_DAMPING,
    H_DEPTH,
    H_DRIVE,
    H_DRIVE_SPEED,
    H_DROPPED,
    H_EVENT_OPEN,
    H_EVENT_REST,
    H_EVENT_SLID,
    H_EXPONENT_TABLE,
    H_FAR_LOST,
    H_FINAL,
    H_FORCE,
    H_FORCE_LIMIT,
    H_FORCE_RATE,
    H_FORCE_SCALE,
    H_GRAVITY,
    H_INERTIA,
    H_INITIAL_FORCE,
    H_INSTANT,
    H_K,
    H_LIFT_TIME,
    H_LOAD,
    H_MASS,
    H_MICRO,
    H_MICROS,
    H_MU,
    H_MU_DRY,
    H_PAST,
    H_PLACE,
    H_POSE,
    H_POWER,
    H_RADIUS,
    H_REACH,
    H_REFERENCE,
    H_RING_TABLE,
    H_SINE,
    H_SLIDING,
    H_SLIP,
    H_SLIPS,
    H_START,
    H_STEP,
    H_STICTION,
    H_STIFFNESS,
    H_SUM,
    H_TARGET,
    H_TICKS,
    H_TIP_RADIUS,
    H_WRENCH,
    H_Z,
    HAND_BRANCHES,
    HAND_FINGERS,
    HAND_FRESH,
    HAND_RATIO,
    HAND_RINGS,
    HAND_SPOKES,
    HAND_TABLE,
    Floats,
)

COURANT_LIMIT = 0.4
WHOLE_SLIDE = 0.95
CREEP_RATE = 1e-3  # [1/s] of the contact radius
COUNTED_SLIDE = 1e-4  # [m]
SLIDE_REST = 0.05  # [s]


def hand_tick(h: Floats, b: Floats) -> None:
    """Advance by one step; ``b`` has rows of force x, y, torque, mass, turn, friction factor by tick."""
    dt = h[H_STEP]
    h[H_TICKS] += 1.0
    row = 6 * int(h[H_TICKS])
    relaxed(h)
    move_drives(h, dt)
    press_tips(h)
    for i in range(HAND_FINGERS):
        h[H_MU + i] = b[row + 5] * h[H_MU_DRY + i]
    if h[H_DROPPED] > 0.5:
        return
    carry_plate(h, b, row, dt)
    count_slips(h, dt)
    x, y, angle = h[H_POSE] - h[H_START], h[H_POSE + 1] - h[H_START + 1], h[H_POSE + 2] - h[H_START + 2]
    if math.sqrt(x * x + y * y) > h[H_FAR_LOST] or abs(angle) > h[H_ANGLE_LOST]:
        lose(h)


def lose(h: Floats) -> None:
    """Let the object go."""
    h[H_DROPPED] = 1.0
    for i in range(HAND_FINGERS):
        h[H_SLIDING + i] = 0.0
        for j in range(3):
            h[H_WRENCH + 3 * i + j] = 0.0
        h[H_SLIP + 3 * i] = h[H_SLIP + 3 * i + 1] = 0.0


def hand_time(h: Floats) -> float:
    """Simulated time [s]."""
    return float(h[H_TICKS] * h[H_STEP])


def relaxed(h: Floats) -> None:
    """Find what all earlier increments contribute to the force of this step [N]."""
    for i in range(HAND_FINGERS):
        past = h[H_FINAL + i] * h[H_SUM + i]
        for j in range(HAND_BRANCHES):
            at = i * HAND_BRANCHES + j
            past += h[H_BRANCH_SHARE + at] * h[H_BRANCH_DECAY + at] * h[H_BRANCHES + at]
        h[H_PAST + i] = past


def elastic_force_of(h: Floats, i: int, depth: float) -> float:
    """Return N_e [N] of finger ``i`` at an indentation [m]."""
    return float(h[H_FORCE_SCALE + i] * (max(depth, 0.0) / h[H_D0 + i]) ** h[H_POWER + i])


def chain_stiffness(h: Floats, i: int) -> float:
    """Return the stiffness [N/m] of tip ``i``."""
    depth = max(h[H_DEPTH + i], 0.05 * h[H_D0 + i])
    return float(h[H_INSTANT + i] * h[H_POWER + i] * elastic_force_of(h, i, depth) / depth)


def move_drives(h: Floats, dt: float) -> None:
    """Move the drives of the opposed fingers towards what is wanted of them."""
    closing = h[H_TICKS] * h[H_STEP] <= h[H_CLOSE_TIME]
    asked, valid = 0.0, 0.0
    for i in range(1, HAND_FINGERS):
        if not math.isnan(h[H_COMMAND + i]):
            asked += h[H_COMMAND + i]
            valid += 1.0
    first = h[H_COMMAND]
    base = chain_stiffness(h, 0)
    for i in range(1, HAND_FINGERS):
        wanted = h[H_COMMAND + i]
        if first > asked:
            if asked > 0.0:
                wanted = wanted * (first / asked)
            elif not math.isnan(wanted):
                wanted = first / max(1.0, valid)
        if closing:
            wanted = h[H_INITIAL_FORCE]
        if h[H_DROPPED] > 0.5:
            wanted = math.nan
        move_drive(h, i, wanted, 1.0 / (1.0 / chain_stiffness(h, i) + (HAND_FINGERS - 1.0) / base), dt)


def move_drive(h: Floats, i: int, wanted: float, stiffness: float, dt: float) -> None:
    """Move one drive for ``dt`` [s]; without a wanted force it stands still."""
    if math.isnan(wanted):
        h[H_TARGET + i] = math.nan
        return
    force = h[H_FORCE + i]
    start = force if math.isnan(h[H_TARGET + i]) else h[H_TARGET + i]
    limited = min(max(wanted, 0.0), h[H_FORCE_LIMIT])
    change = h[H_FORCE_RATE] * dt
    h[H_TARGET + i] = start + min(max(limited - start, -change), change)
    error = h[H_TARGET + i] - force
    pull = error - min(max(error, -h[H_STICTION]), h[H_STICTION])
    speed = 2.0 * math.pi * h[H_BANDWIDTH] * pull / stiffness
    speed = min(max(speed, -h[H_DRIVE_SPEED]), h[H_DRIVE_SPEED])
    if not math.isnan(speed):
        h[H_DRIVE + i] += dt * speed


def press_tips(h: Floats) -> None:
    """Put the object where the normal forces cancel, and press the tips."""
    z = balanced_place(h, h[H_Z])
    h[H_Z] = z
    for i in range(HAND_FINGERS):
        depth = h[H_DRIVE + i] + (z if i == 0 else -z)
        if h[H_DROPPED] > 0.5:
            depth = -h[H_D0 + i]
        press_tip(h, i, depth)


def press_tip(h: Floats, i: int, depth: float) -> None:
    """Impose an indentation [m] on tip ``i``."""
    elastic = elastic_force_of(h, i, depth)
    force = max(h[H_PAST + i] + h[H_INSTANT + i] * (elastic - h[H_BEFORE + i]), 0.0)
    increment = (force - h[H_PAST + i]) / h[H_INSTANT + i]
    h[H_BEFORE + i] += increment
    h[H_SUM + i] += increment
    for j in range(HAND_BRANCHES):
        at = i * HAND_BRANCHES + j
        h[H_BRANCHES + at] = h[H_BRANCH_DECAY + at] * h[H_BRANCHES + at] + increment
    h[H_FORCE + i], h[H_DEPTH + i] = force, depth
    h[H_REFERENCE + i] = max(h[H_REFERENCE + i], force) if force > 0.0 else 0.0
    held = max(depth, 0.0) if force > 0.0 else 0.0
    h[H_RADIUS + i] = math.sqrt(2.0 * h[H_TIP_RADIUS + i] * held)
    fresh = h[H_D0 + i] * (h[H_REFERENCE + i] / h[H_FORCE_SCALE + i]) ** (1.0 / h[H_POWER + i])
    creep = depth / fresh if fresh > 0.0 else 1.0
    h[H_K + i] = exponent_of(h, HAND_FRESH / max(creep, 1.0))


def exponent_of(h: Floats, coefficient: float) -> float:
    """Return the pressure exponent of a coefficient C_k, from the table."""
    wanted = -math.log(max(coefficient - 1.0, 1e-12))
    low, high = 0, HAND_TABLE  # the first place whose value is not below the wanted one
    while low < high:
        middle = (low + high) // 2
        if h[H_EXPONENT_TABLE + middle] < wanted:
            low = middle + 1
        else:
            high = middle
    j = low - 1
    j = max(j, 0)
    j = min(j, HAND_TABLE - 2)
    here, there = h[H_EXPONENT_TABLE + j], h[H_EXPONENT_TABLE + j + 1]
    part = min(max((wanted - here) / (there - here), 0.0), 1.0)
    return math.exp(HAND_RATIO * (j + part))


def balanced_place(h: Floats, z: float) -> float:
    """Return the place of the object [m] at which the normal forces of all fingers cancel."""
    low, high = -math.inf, math.inf
    scale = 0.0
    for i in range(HAND_FINGERS):
        scale = max(scale, h[H_D0 + i])
    for _ in range(200):
        residual, slope, total = balance_residual(h, z)
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


def balance_residual(h: Floats, z: float) -> tuple[float, float, float]:
    """Return the sum of the normal forces with their sides, its slope over z, and the sum without."""
    residual, slope, total = 0.0, 0.0, 0.0
    for i in range(HAND_FINGERS):
        side = 1.0 if i == 0 else -1.0
        d = h[H_DRIVE + i] + side * z
        N = max(0.0, h[H_PAST + i] + h[H_INSTANT + i] * (elastic_force_of(h, i, d) - h[H_BEFORE + i]))
        if N > 0.0 and d > 0.0:
            residual += side * N
            total += N
            bend = (d / h[H_D0 + i]) ** (h[H_POWER + i] - 1.0)
            slope += h[H_INSTANT + i] * h[H_POWER + i] * h[H_FORCE_SCALE + i] * bend / h[H_D0 + i]
    return residual, slope, total


def load_rings(h: Floats, i: int) -> None:
    """Fill the share of the normal force on one element of each ring of patch ``i``."""
    place = min(max(math.log(h[H_K + i]) / HAND_RATIO, 0.0), HAND_TABLE - 1.0)
    j = int(place)
    j = min(j, HAND_TABLE - 2)
    for ring in range(HAND_RINGS):
        here = h[H_RING_TABLE + j * HAND_RINGS + ring]
        there = h[H_RING_TABLE + (j + 1) * HAND_RINGS + ring]
        h[H_LOAD + i * HAND_RINGS + ring] = here + (place - j) * (there - here)


def carry_plate(h: Floats, b: Floats, row: int, dt: float) -> None:
    """Move the object for ``dt`` [s]."""
    now = h[H_TICKS] * h[H_STEP]
    gone = now - h[H_CLOSE_TIME]
    if h[H_LIFT_TIME] > 0.0:
        stand = min(max(1.0 - gone / h[H_LIFT_TIME], 0.0), 1.0)
    else:
        stand = 1.0 if gone <= 0.0 else 0.0
    mass = h[H_MASS] + b[row + 3]
    weight = (1.0 - stand) * mass * h[H_GRAVITY]
    fx = b[row] + weight * math.sin(b[row + 4])
    fy = b[row + 1] - weight * math.cos(b[row + 4])
    for i in range(HAND_FINGERS):
        load_rings(h, i)
    count = plate_substeps(h, mass, dt)
    for _ in range(count):
        move_plate(h, mass, fx, fy, b[row + 2], dt / count)


def plate_substeps(h: Floats, mass: float, dt: float) -> int:
    """Return how finely to divide a step for the explicit scheme."""
    push, turn, push_damped, turn_damped = 0.0, 0.0, 0.0, 0.0
    for i in range(HAND_FINGERS):
        a2 = h[H_RADIUS + i] * h[H_RADIUS + i]
        stiffness = h[H_STIFFNESS + i] * math.pi * a2
        lx, ly = h[H_PLACE + 2 * i] - h[H_POSE], h[H_PLACE + 2 * i + 1] - h[H_POSE + 1]
        turning = stiffness * (lx * lx + ly * ly + 0.5 * a2) / h[H_INERTIA]
        push += stiffness / mass
        turn += turning
        push_damped += stiffness / mass * h[H_DAMPING + i]
        turn_damped += turning * h[H_DAMPING + i]
    free, damped = math.sqrt(max(push, turn)), max(push_damped, turn_damped)
    fastest = max(free, damped)
    return int(max(1.0, math.ceil(dt * fastest / COURANT_LIMIT)))


def move_plate(h: Floats, mass: float, fx: float, fy: float, torque: float, dt: float) -> None:
    """One substep: friction of all patches, then symplectic Euler."""
    for i in range(HAND_FINGERS):
        lx, ly = h[H_PLACE + 2 * i] - h[H_POSE], h[H_PLACE + 2 * i + 1] - h[H_POSE + 1]
        spin = h[H_POSE + 5]
        rub_patch(h, i, h[H_POSE + 3] - spin * ly, h[H_POSE + 4] + spin * lx, spin, dt)
        tx, ty = h[H_WRENCH + 3 * i], h[H_WRENCH + 3 * i + 1]
        h[H_SLIP + 3 * i + 2] += h[H_SLIP + 3 * i + 1] * dt
        fx -= tx
        fy -= ty
        torque -= h[H_WRENCH + 3 * i + 2] + lx * ty - ly * tx
    h[H_POSE + 3] += dt * fx / mass
    h[H_POSE + 4] += dt * fy / mass
    h[H_POSE + 5] += dt * torque / h[H_INERTIA]
    for j in range(3):
        h[H_POSE + j] += dt * h[H_POSE + 3 + j]


def rub_patch(h: Floats, i: int, vx: float, vy: float, spin: float, dt: float) -> None:
    """Move the object over patch ``i``, as :func:`vegrip.virtual.kernels.rub` does."""
    fx, fy, torque, speed, passing = 0.0, 0.0, 0.0, 0.0, 0.0
    a, N = h[H_RADIUS + i], h[H_FORCE + i]
    first = H_BRISTLE + 2 * HAND_RINGS * HAND_SPOKES * i
    if N <= 0.0 or a <= 0.0:
        for j in range(2 * HAND_RINGS * HAND_SPOKES):
            h[first + j] = 0.0
    else:
        patch = math.pi * a * a
        for ring in range(HAND_RINGS):
            share = h[H_LOAD + i * HAND_RINGS + ring]
            s = h[H_STIFFNESS + i] * patch * h[H_AREA + ring]
            c = s * h[H_DAMPING + i]
            limit = h[H_MU + i] * N * share
            rho = a * h[H_REACH + ring]
            for j in range(HAND_SPOKES):
                at = first + 2 * (ring * HAND_SPOKES + j)
                x, y = rho * h[H_COSINE + j], rho * h[H_SINE + j]
                wx, wy = vx - spin * y, vy + spin * x
                passing += share * math.sqrt(wx * wx + wy * wy)
                qx, qy = h[at], h[at + 1]
                nx, ny = qx + wx * dt, qy + wy * dt
                tx, ty = s * nx + c * wx, s * ny + c * wy
                t = math.sqrt(tx * tx + ty * ty)
                if t > limit:
                    tx *= limit / t
                    ty *= limit / t
                    mx, my = (tx + c * qx / dt) / (s + c / dt), (ty + c * qy / dt) / (s + c / dt)
                    ex, ey = nx - mx, ny - my
                    speed += share * math.sqrt(ex * ex + ey * ey) / dt
                    nx, ny = mx, my
                h[at], h[at + 1] = nx, ny
                fx += tx
                fy += ty
                torque += x * ty - y * tx
    h[H_WRENCH + 3 * i], h[H_WRENCH + 3 * i + 1], h[H_WRENCH + 3 * i + 2] = fx, fy, torque
    h[H_SLIP + 3 * i] = min(1.0, speed / passing) if passing > 0.0 else 0.0
    h[H_SLIP + 3 * i + 1] = speed


def count_slips(h: Floats, dt: float) -> None:
    """Count slides of a whole patch: slips beyond COUNTED_SLIDE, micro-slips below."""
    some = False
    for i in range(HAND_FINGERS):
        whole = h[H_SLIP + 3 * i] > WHOLE_SLIDE and h[H_SLIP + 3 * i + 1] > CREEP_RATE * h[H_RADIUS + i]
        h[H_SLIDING + i] = 1.0 if whole else 0.0
        some = some or whole
    if some:
        if h[H_EVENT_OPEN] < 0.5:
            h[H_EVENT_OPEN], h[H_COUNTED] = 1.0, 0.0
            for i in range(HAND_FINGERS):
                h[H_EVENT_SLID + i] = 0.0
        h[H_EVENT_REST] = 0.0
        most = 0.0
        for i in range(HAND_FINGERS):
            if h[H_SLIDING + i] > 0.5:
                h[H_EVENT_SLID + i] += h[H_SLIP + 3 * i + 1] * dt
            most = max(most, h[H_EVENT_SLID + i])
        if h[H_COUNTED] < 0.5 and most > COUNTED_SLIDE:
            h[H_COUNTED] = 1.0
            h[H_SLIPS] += 1.0
    elif h[H_EVENT_OPEN] > 0.5:
        h[H_EVENT_REST] += dt
        if h[H_EVENT_REST] >= SLIDE_REST:
            close_event(h)


def close_event(h: Floats) -> None:
    """End the present slide; one that does not count as a slip is a micro-slip."""
    h[H_EVENT_OPEN] = 0.0
    if h[H_COUNTED] < 0.5:
        h[H_MICROS] += 1.0
        for i in range(HAND_FINGERS):
            h[H_MICRO] = max(h[H_MICRO], h[H_EVENT_SLID + i])


def limit_on_patch(h: Floats, i: int, f: float, torque: float) -> float:
    """Return the distance to the limit surface of patch ``i`` along the load (f, torque), both normalised."""
    low, high = 0.0, 1.0
    radius = 1.0
    for _ in range(60):
        part = 0.5 * (low + high)
        d = part / (1.0 - part)
        there_f, there_m = 0.0, 0.0
        for ring in range(HAND_RINGS):
            share, r = h[H_LOAD + i * HAND_RINGS + ring], h[H_REACH + ring]
            for j in range(HAND_SPOKES):
                x, y = r * h[H_COSINE + j], r * h[H_SINE + j]
                rho = math.sqrt((x - d) * (x - d) + y * y)
                if rho > 0.0:
                    there_f -= share * (x - d) / rho
                    there_m += share * (x * (x - d) + y * y) / rho
        radius = math.sqrt(there_f * there_f + there_m * there_m)
        if there_f * torque < there_m * f:
            low = part
        else:
            high = part
        if high - low < 1e-7:
            break
    return radius


def true_margin(h: Floats, i: int) -> float:
    """Return the true slip margin of finger ``i`` [-]."""
    N, a = h[H_FORCE + i], h[H_RADIUS + i]
    if not (N > 0.0 and a > 0.0):
        return 1.0
    limit = h[H_MU + i] * N
    x, y = h[H_WRENCH + 3 * i], h[H_WRENCH + 3 * i + 1]
    f, torque = math.sqrt(x * x + y * y) / limit, abs(h[H_WRENCH + 3 * i + 2]) / (limit * a)
    size = math.sqrt(f * f + torque * torque)
    if size == 0.0:
        return 1.0
    load_rings(h, i)
    return 1.0 - size / limit_on_patch(h, i, f, torque)
