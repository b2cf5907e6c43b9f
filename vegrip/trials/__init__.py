"""Hand and control in simulated time: the same hands, objects and disturbances for every controller."""
