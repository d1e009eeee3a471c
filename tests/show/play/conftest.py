"""The page, opened in a real browser and paused."""

import pytest

from jaxwalk.learn.policies import named
from jaxwalk.show.play import page

READY = "new Promise(done => { const see = () => globalThis.jaxwalk ? done() : setTimeout(see, 10); see(); })"


@pytest.fixture(scope="module")
def shipped():
    return named.load("shipped")


@pytest.fixture(scope="module")
def file(shipped, tmp_path_factory):
    path = tmp_path_factory.mktemp("play") / "play.html"
    path.write_bytes(page.html(shipped, named.origin("shipped"), "jaxwalk play shipped"))
    return path


@pytest.fixture
def paused(browser, file):
    """Gives the page, opened anew in a window of a size, paused."""

    def show(*size):
        one = browser(file, *size)
        one.run(READY)
        one.run("document.getElementById('play').click()")
        return one

    return show


@pytest.fixture
def still(paused):
    """The page, paused."""
    return paused()
