"""Thin programs: each reads its configuration, opens its endpoint, runs its loop and shuts down."""
