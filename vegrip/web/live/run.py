"""Run the live page until it is interrupted."""

from collections.abc import Callable
from contextlib import closing

from vegrip.web.live.page import routes
from vegrip.web.live.stream import Stream
from vegrip.web.server import serve


def run(port: int, announce: Callable[[str], None], *, opens: bool = False) -> None:
    """Hear all nodes of this machine, those that come later as well, and serve the page that shows them.

    Raises:
        DeviceError: the port is in use.

    """
    with closing(Stream()) as stream:
        stream.start()
        serve(routes(stream), port, announce, opens=opens)
