"""What the page about robots among themselves says is what the code does."""

from __future__ import annotations

import re
from pathlib import Path
from typing import get_args

from rosic.contracts.among import UTTERANCE_BYTES
from rosic.core import among
from rosic.core.authority import AMONG
from rosic.pipeline.among import digests, fellowship, guard, helpdesk, inbox, post, strategies

PAGE = Path(__file__).parents[4] / "docs" / "robots" / "among.md"


def test_every_utterance_that_is_shown_can_be_said() -> None:
    text = PAGE.read_text(encoding="utf-8")
    shown = [one for one in re.findall(r"`(\{\"kind\".*?\})`", text) if '"result"' not in one]
    read = [
        among.read_utterance(one.replace("...", '"x"').encode(), UTTERANCE_BYTES) for one in shown
    ]
    said = {type(utterance) for utterance in read} | {among.Unfollow}
    assert said == set(get_args(among.Utterance)), "each kind is shown"


def test_it_gives_the_right_figures() -> None:
    text = " ".join(PAGE.read_text(encoding="utf-8").split())
    for words in (
        f"One utterance: {UTTERANCE_BYTES // 1024} KiB; data in it: {among.DATA_BYTES // 1024} KiB",
        f"{among.TOPICS_A_ROBOT} topics and {among.ROBOT_BYTES // 1024} KiB in all",
        f"a queue of {inbox.WAITING_AT_MOST} and a pace of {inbox.PACE.per_s:g} a second",
        f"after {inbox.PACE.burst:g} at once",
        f"at most {post.PAIR_PACE.per_s:g} a second from each robot",
        f"written down, once in {fellowship.SAVE_EVERY_S:g} s",
        f"at most {helpdesk.CALLS.burst:g} times at once",
        f"after {guard.HOPS_AT_MOST} hops",
        f"for {guard.CUT_NS // 60_000_000_000} minutes nothing passes",
        f"{guard.CONVERSATION.burst:g} at once and one in {1 / guard.CONVERSATION.per_s:g} s",
        f"at most one message in {digests.EVERY_S:g} s",
        f"for {strategies.IDLE_WITHIN_S / 60:g} min at most",
        f"after {strategies.ANSWER_WITHIN_S:g} s without one",
        f"`for_s`: nobody can accept it later ({among.HELP_FOR_S:g})",
    ):
        assert words in text, words
    assert all(f":{word}`" in text for word in AMONG)
