"""Soft viscoelastic contact as in [TiezziKao2007]_: pure functions, vectorised, one idea a file.

==================  =================================================  ====================================
module              what                                               equations
==================  =================================================  ====================================
``geometry``        contact radius, local depression                   (1), (32)
``pressure``        pressure profile, its coefficient, peak, torsion   (2)-(4), (9), (17), (21)-(24)
``elastic``         instantaneous force law and its inverse            (11)-(14), (28), (29), (44)-(46)
``prony``           relaxation g, creep h, j conjugate to g            (15), (30), (41)
``hereditary``      any history of displacement and load               (5), (7), (10), (16)-(20), (43)
``creep``           indentation under imposed load, two laws           (6), (8), (27), (31)-(34), (42)-(47)
``coupling``        radius and exponent move together; what drives it  (25), (35), (36), (39), (40), (48)
``paper``           its tables, figures and fitted forms               (26), (37), (38), (59)-(65)
``limit_surface``   friction limit surface                             (49)-(58)
==================  =================================================  ====================================

Everything is SI. Arguments broadcast as in numpy; scalars are arrays without dimensions. A question outside
the range where the answer is known raises :class:`vegrip.errors.DomainError`.
"""
