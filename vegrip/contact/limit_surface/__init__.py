"""The friction limit surface: which tangential force and torque a soft contact carries before it slips."""
