"""The demonstration: a virtual hand holds an object while it is disturbed."""
