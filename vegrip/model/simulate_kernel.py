"""A whole record through the model, one compiled call."""

import numpy as np

from vegrip.model.generated import N_OUTSIDE, N_STATES, Floats, advance, readout


def run(values: Floats, states: Floats, t: Floats, inputs: Floats, out: Floats) -> None:
    """Step through ``inputs`` (rows: delta, speed, then exogenous) at times ``t``; starts from ``states``.

    ``out`` (n, 7) receives x, elastic_force, force, sensed_force, contact_radius, exponent, friction;
    ``states`` ends as the last ones.

    Loops instead of slices: setting a slice brings numba's string code for the message of a wrong shape with
    it, more than half of the time to compile.
    """
    n = values.shape[0]
    m = np.empty(n + N_OUTSIDE + N_STATES)
    outside, at = n, n + N_OUTSIDE
    for j in range(n):
        m[j] = values[j]
    for j in range(N_STATES):
        m[at + j] = states[j]
    elastic_force = 0.0
    before = t[0]
    for i in range(t.shape[0]):
        delta, speed = inputs[i, 0], inputs[i, 1]
        for j in range(N_OUTSIDE):
            m[outside + j] = inputs[i, 2 + j]
        if i == 0:
            elastic_force = advance(m, 0, at, delta, speed, outside, 0.0, 0.0, at)[1]
        x, elastic_force, force, sensed_force = advance(
            m, 0, at, delta, speed, outside, elastic_force, t[i] - before, at
        )
        radius, exponent, friction = readout(m, 0, at, delta, speed, outside, x, elastic_force, force)
        before = t[i]
        out[i, 0], out[i, 1], out[i, 2], out[i, 3] = x, elastic_force, force, sensed_force
        out[i, 4], out[i, 5], out[i, 6] = radius, exponent, friction
    for j in range(N_STATES):
        states[j] = m[at + j]
