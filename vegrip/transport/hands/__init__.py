"""Endpoints of hands that a map describes, and the virtual devices that speak as they do."""
