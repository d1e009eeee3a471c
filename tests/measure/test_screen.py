"""What a measurement says on a terminal while it goes on."""

import io

from rich.console import Console

from jaxwalk.measure import screen


def test_a_user_s_name_is_shown_as_it_is():
    """It is no markup, which would be eaten, or refused."""
    shown = io.StringIO()
    console = Console(file=shown, force_terminal=True, width=100, markup=False)
    with screen.bars(console) as progress:
        progress("a[/x] [red]*?, walking", 0.5)
    assert "a[/x] [red]*?, walking" in shown.getvalue()
