"""The friction limit surface of a soft contact: which tangential force and torque it carries before it slips."""
