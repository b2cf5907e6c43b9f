"""The tables and figures of [TiezziKao2007]_, computed anew from :mod:`vegrip.contact`."""
