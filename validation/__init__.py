"""What the project checks itself by; not installed."""
