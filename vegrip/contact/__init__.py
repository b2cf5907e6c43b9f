"""The contact of a soft fingertip as pure functions: geometry, pressure, relaxation, creep, friction limit."""
