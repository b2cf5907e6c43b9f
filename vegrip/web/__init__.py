"""Pages for a browser on this machine: what is shown, the server, and what the browser loads.

``live`` shows running nodes, ``check`` a model against a recording, ``report`` writes either to one file. Pages
are built by pure functions from values; ``server`` and ``guard`` are the rim. Nothing here is imported by a node.
"""
