"""Soft viscoelastic contact as in [TiezziKao2007]_: pure functions, vectorised, one file per idea.

===================  ================================================  ==============================
module               what                                              equations
===================  ================================================  ==============================
``geometry``         contact radius, local depression                  (1), (32)
``pressure``         pressure profile, its coefficient, peak, torsion  (2)-(4), (9), (17), (21)-(24)
``elastic``          instantaneous force law and its inverse           (11)-(14), (28), (29), (44)-(46)
``prony``            reduced relaxation g, reduced creep h and j       (15), (30), (41)
``conjugate``        which j belongs to which g, exactly               not in the paper
``hereditary``       the recursion behind every history integral       (20), (43)
``relaxation``       force under imposed displacement                  (5), (7), (10), (16)-(20)
``creep``            indentation under imposed load, two laws          (6), (8), (27), (31)-(34), (42)-(47)
``history``          mixed histories, contact lost and made again      (20) and its inverse
``coupling``         contact radius and pressure exponent move together(25), (35), (36), (39), (40)
``coupling_fits``    the paper's fitted forms of it                    (26), (37), (38), (59)-(65)
``creep_ratio``      what drives the coupling in any history           (48)
``limit_surface``    friction limit surface                            (49)-(58)
===================  ================================================  ==============================

Everything is SI. Arguments broadcast as in numpy; scalars are arrays without dimensions. A question outside
the range where the answer is known raises :class:`vegrip.errors.DomainError`.
"""
