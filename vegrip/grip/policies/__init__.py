"""How much force a finger shall apply: the margin policy, and those that it is compared with."""
