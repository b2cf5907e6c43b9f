"""A whole record through the model, one compiled call."""

from vegrip.model.channels_kernel import GIVEN, NOW
from vegrip.model.generated import N_OUTSIDE, N_STATES, Floats, advance, readout


def run(values: Floats, states: Floats, t: Floats, inputs: Floats, out: Floats, m: Floats, n: int) -> None:
    """Step through ``n`` rows of ``inputs`` (delta, speed, then outside) at times ``t`` from ``states``.

    The arrays are flat. ``out`` (n, 7) receives x, elastic_force, force, sensed_force, contact_radius,
    exponent, friction; ``states`` ends as the last ones; ``m`` is room for one step.
    """
    for j in range(GIVEN):
        m[j] = values[j]
    for j in range(N_STATES):
        m[NOW + j] = states[j]
    elastic_force = 0.0
    before = t[0]
    for i in range(n):
        row = (2 + N_OUTSIDE) * i
        delta, speed = inputs[row], inputs[row + 1]
        for j in range(N_OUTSIDE):
            m[GIVEN + j] = inputs[row + 2 + j]
        if i == 0:
            elastic_force = advance(m, 0, NOW, delta, speed, GIVEN, 0.0, 0.0, NOW)[1]
        dt = t[i] - before
        x, elastic_force, force, sensed = advance(m, 0, NOW, delta, speed, GIVEN, elastic_force, dt, NOW)
        radius, exponent, friction = readout(m, 0, NOW, delta, speed, GIVEN, x, elastic_force, force)
        before = t[i]
        o = 7 * i
        out[o], out[o + 1], out[o + 2], out[o + 3] = x, elastic_force, force, sensed
        out[o + 4], out[o + 5], out[o + 6] = radius, exponent, friction
    for j in range(N_STATES):
        states[j] = m[NOW + j]
