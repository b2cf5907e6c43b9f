"""Controllers on the same hands, objects and disturbances, in simulated time."""
