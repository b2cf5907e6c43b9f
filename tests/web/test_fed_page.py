"""The page of a program that has the messages at hand: nothing is worked out until a page looks."""

import time
import urllib.error
import urllib.request
from contextlib import closing

import pytest

from vegrip.messages import Estimate, SlipMargin
from vegrip.web.live.stream import FedPage


def margin(stamp: int) -> SlipMargin:
    value = Estimate(0.6, 0.05, True, 0.0)
    return SlipMargin(stamp, "thumb", 0, value, 0.5, 0.95, 1.0, 9.0, 5.0)


@pytest.fixture
def page():
    with closing(FedPage(0.15, 0)) as page:
        yield page


def test_nothing_is_taken_until_a_page_looks(page: FedPage) -> None:
    now = time.monotonic_ns()
    page.take(margin(now), now, "/grasp_force")
    page.tick()
    assert page.first()[1].startswith('{"layout"')  # no event was made
    page.take(margin(now), time.monotonic_ns(), "/grasp_force")
    page.tick()
    number, text = page.since(0)
    assert number == 1
    assert '"thumb"' in text
    assert '"wanted":0.15' in text


def test_the_page_is_served_with_its_key_and_ends(page: FedPage) -> None:
    opener = urllib.request.build_opener(urllib.request.HTTPCookieProcessor())
    with opener.open(page.address) as answer:
        assert b"vegrip" in answer.read()
    with pytest.raises(urllib.error.HTTPError, match="403"):
        urllib.request.build_opener().open(page.address.split("?")[0])
