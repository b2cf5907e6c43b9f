"""The friction limit surface: which tangential force and torque a soft contact carries before it slips.

reference      the paper's profile and any round one, exactly, by quadrature over rings
fast           the paper's profile in a tenth of a microsecond, compiled; tools/fit_limit_surface.py fits it
queries        the fast surface for arrays, with every argument checked
least_force    the least normal force for a load, and how the contact grows with that force
pressure_map   any map of points with forces, the usual shapes among them; bounds of the gauge of a load
"""
