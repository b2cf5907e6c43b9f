"""The compiled part of the estimator, as source.

The files are ordinary ones, to be read, linted and typed; nothing imports them. Their text stands in the
generated module of a model; ``python -m tools.write_declarations`` declares what they find there.

Extended Kalman filter of one contact; state delta, speed, effects, learned parameters, d0, bF::

    delta' = speed,  speed' = white,  effects' = advance,  parameters, d0, bF: random walks
    displacement = delta + d0 + noise,  normal_force = sensed_force + bF + noise,
    contact_radius = a + noise

The model enters only through ``advance`` and ``readout``, so any list of effects works; derivatives are
finite differences scaled by the standard deviations. Measurements are scalar and come one after the other,
each linearised where the last one has left the state. Plain loops over one flat array ``m`` per finger.
"""
