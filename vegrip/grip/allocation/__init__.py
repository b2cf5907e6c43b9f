"""How the fingers share a grasp: balance, and the internal forces of any number of contacts."""
