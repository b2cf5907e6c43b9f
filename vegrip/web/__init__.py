"""Pages for a browser on this machine: what is shown, the server, and what the browser loads.

``live`` shows running nodes. What is shown is worked out by pure functions; ``server`` and ``guard`` are the
rim. No node imports anything of this.
"""
