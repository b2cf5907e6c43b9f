"""The tangential load on a fingertip whose counter-surface moves: it rises elastically, then slides.

A Hertzian contact of an incompressible body is 2/3 as stiff tangentially as normally [Mindlin1949]_, and
``dN/dx = 3 N / (2 x)``, so a deflection (u_x, u_y, theta) since the motion began loads it with
``N / x (u_x, u_y, a^2 theta)``. Where that lies beyond the limit surface of the model, the contact slides and
the deflection stays at the limit. A change of direction begins without a load.
"""

import numpy as np
from numpy.typing import NDArray

from vegrip.identification.simulate.timeline import Floats, Timeline
from vegrip.model import ContactModel, Predictor
from vegrip.model.channels import QUANTITIES

ROUNDS = 3  # friction may depend on the speed of sliding, and force and radius on the load
AT = {name: i for i, name in enumerate(QUANTITIES)}


def moves(line: Timeline) -> NDArray[np.bool_]:
    """Return the rows (n,) at which the counter-surface moves."""
    out: NDArray[np.bool_] = np.any(line.pull != 0.0, axis=1)
    return out


def rubbed(model: ContactModel, line: Timeline, columns: dict[str, Floats]) -> dict[str, Floats]:
    """Return ``columns`` with tangential force x, y [N], torque [N m], slip and its speed [m/s]."""
    none = np.zeros(line.t.size)
    loads = {"tangential_force_x": none, "tangential_force_y": none, "torque_z": none}
    full = {**columns, **loads, "slip": none, "slip_speed": none}
    moving, heading = moves(line), _heading(line)
    if not moving.any():
        return full
    table = Predictor(model, full, drive="displacement", load="model")(model.vector)
    deflection = np.where(moving, 1e-6, 0.0)  # [s] of motion: something to find the direction of the limit
    for _ in range(ROUNDS):
        full |= _loads(table, heading, deflection)
        table = Predictor(model, full, drive="displacement", load="model")(model.vector)
        used = table[:, AT["utilisation"]]
        limit = np.where(used > 0.0, deflection / np.where(used > 0.0, used, 1.0), np.inf)
        touching = table[:, AT["contact_force"]] > 0.0
        deflection, sliding = _deflection(line, moving, limit, touching)
        velocity, a = line.pull, table[:, AT["contact_radius"]]
        speed = np.hypot(np.hypot(velocity[:, 0], velocity[:, 1]), 2.0 / 3.0 * a * velocity[:, 2])
        full |= {"slip": sliding.astype(np.float64), "slip_speed": np.where(sliding, speed, 0.0)}
    return full | _loads(table, heading, deflection)


def _heading(line: Timeline) -> Floats:
    """Return the last velocity (n, 3) at which the counter-surface moved in this episode."""
    out = np.zeros_like(line.pull)
    last = np.zeros(3)
    for piece in line.pieces:
        now = line.pull[piece.begin]
        if np.any(now != 0.0):
            last = now
        elif piece.begin == 0 or line.episode[piece.begin] != line.episode[piece.begin - 1]:
            last = np.zeros(3)
        out[piece.begin : piece.end] = last
    return out


def _loads(table: Floats, heading: Floats, deflection: Floats) -> dict[str, Floats]:
    N, x, a = (table[:, AT[name]] for name in ("contact_force", "indentation", "contact_radius"))
    stiffness = np.where((N > 0.0) & (x > 0.0), N / np.where(x > 0.0, x, 1.0), 0.0) * deflection
    fx, fy, torque = stiffness * heading[:, 0], stiffness * heading[:, 1], stiffness * a * a * heading[:, 2]
    return {"tangential_force_x": fx, "tangential_force_y": fy, "torque_z": torque}


def _deflection(
    line: Timeline, moving: NDArray[np.bool_], limit: Floats, touching: NDArray[np.bool_]
) -> tuple[Floats, NDArray[np.bool_]]:
    """Return the elastic deflection, as seconds of motion, and where the contact slides."""
    out, sliding = np.zeros(line.t.size), np.zeros(line.t.size, dtype=bool)
    for piece in line.pieces:
        fresh = piece.begin == 0 or line.episode[piece.begin] != line.episode[piece.begin - 1]
        turned = (
            not fresh and moving[piece.begin] and np.any(line.pull[piece.begin] != line.pull[piece.begin - 1])
        )
        now = 0.0 if fresh or turned else float(out[piece.begin - 1])
        for i in range(piece.begin, piece.end):
            if not touching[i]:
                now = 0.0
            elif moving[i]:
                now += float(line.t[i] - line.t[i - 1]) if i > piece.begin else 0.0
            if now > limit[i]:
                now, sliding[i] = float(limit[i]), bool(moving[i])
            out[i] = now
    return out, sliding
