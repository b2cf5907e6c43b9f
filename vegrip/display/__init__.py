"""How results show themselves: the text of the terminal, the card of a notebook, pictures, tables, JSON.

One module a kind of value; :class:`~vegrip.displayed.Displayed` calls ``brief``, ``text`` and ``card`` of it,
:class:`~vegrip.displayed.Result` also ``figure``, ``columns`` and ``as_json``.
"""
