"""A real browser, where there is one."""

import pytest
from chromium import PROGRAM, Browser


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    """Gives the browser with a page opened anew, of a size, in a theme, with motion or without."""
    if PROGRAM is None:
        pytest.skip("no Chromium here: install Debian's chromium")
    with Browser(tmp_path_factory.mktemp("profile")) as one:

        def show(path, width=1280, height=800, **media):
            one.show(path, width, height, **media)
            return one

        yield show
