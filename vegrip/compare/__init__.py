"""Where a model fails: residuals by regime, two models side by side."""
