"""A whole record through the model, one compiled call."""

from vegrip.model.generated import Floats, advance, readout


def run(values: Floats, states: Floats, t: Floats, inputs: Floats, out: Floats) -> None:
    """Step through ``inputs`` (rows: delta, speed, then exogenous) at times ``t``; starts from ``states``.

    ``out`` (n, 7) receives x, elastic_force, force, sensed_force, contact_radius, exponent, friction;
    ``states`` ends as the last ones.
    """
    elastic_force = 0.0
    before = t[0]
    for i in range(t.shape[0]):
        delta, speed, exogenous = inputs[i, 0], inputs[i, 1], inputs[i, 2:]
        if i == 0:
            _, elastic_force, _, _ = advance(values, states, delta, speed, exogenous, 0.0, 0.0, states)
        x, elastic_force, force, sensed_force = advance(
            values, states, delta, speed, exogenous, elastic_force, t[i] - before, states
        )
        radius, exponent, friction = readout(values, states, delta, speed, exogenous, x, elastic_force, force)
        before = t[i]
        out[i, 0], out[i, 1], out[i, 2], out[i, 3] = x, elastic_force, force, sensed_force
        out[i, 4], out[i, 5], out[i, 6] = radius, exponent, friction
