"""Is the estimator's standard deviation honest? Simulated truths, three sensor configurations, one table."""
