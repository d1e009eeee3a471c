"""Whose commands count, and for how long."""

from __future__ import annotations

import math

from jaxwalk.ros.inbox import Inbox
from jaxwalk.ros.watch import OLDEST
from jaxwalk.ros.wire import PASSIVE

TICK = 2_000_000  # ns


def give(inbox, values, sender="/one"):
    for joint, value in enumerate(values):
        inbox.put(joint, value, sender)


def test_a_command_is_for_one_frame_and_complete_or_passive(said):
    inbox = Inbox(6, said.append)
    inbox.open(0)
    give(inbox, range(6))
    assert inbox.wait(0.0) == (0, 1, 2, 3, 4, 5) and math.isfinite(inbox.latency)
    inbox.open(TICK)
    give(inbox, range(5))
    assert inbox.wait(0.0) is PASSIVE
    assert said == ["no command within 0 s: joints are passive"]
    inbox.open(2 * TICK)
    give(inbox, [7.0] * 6, "/two")  # the first is lost: another may take over
    assert inbox.wait(0.0) == (7.0,) * 6


def test_a_second_controller_is_left_out(said):
    inbox = Inbox(6, said.append)
    inbox.open(0)
    inbox.put(0, 1.0, "/one")
    give(inbox, [9.0] * 6, "/two")
    give(inbox, [1.0] * 6, "/one")
    give(inbox, [9.0] * 6, "/two")
    assert inbox.wait(0.0) == (1.0,) * 6
    assert said == ["commands of /two are left out: /one controls the walker"]


def test_in_real_time_no_command_is_held_for_longer_than_20_ms(said):
    inbox = Inbox(6, said.append)
    assert inbox.newest(0) is PASSIVE and said == []
    inbox.open(0)
    give(inbox, [3.0] * 6)
    assert inbox.newest(OLDEST) == (3.0,) * 6
    assert inbox.newest(OLDEST + 1) is PASSIVE and inbox.newest(OLDEST + 2) is PASSIVE
    assert len(said) == 1 and "no command for more than 20 ms" in said[0]
