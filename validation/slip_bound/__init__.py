"""Whether the bound of the margin holds: grasps whose force is set from outside, whatever it says.

Under a grip that keeps its bound above zero every slide has a bound above zero: that selects, and measures
nothing. So the force is drawn about the least that holds, and the true margin is compared with what is said.
"""
