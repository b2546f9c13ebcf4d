"""What the page about robots among themselves says is what the code does."""

from __future__ import annotations

import re
from pathlib import Path
from typing import get_args

from rosic.contracts.robot import UTTERANCE_BYTES
from rosic.core.policy.scope import AMONG
from rosic.core.robot import dialogue_protocol
from rosic.features.robot_to_robot import (
    digest,
    help_service,
    inbox,
    service,
    strategies,
    subscriptions,
)

PAGE = Path(__file__).parents[3] / "docs" / "robots" / "among.md"


def test_every_utterance_that_is_shown_can_be_said() -> None:
    text = PAGE.read_text(encoding="utf-8")
    shown = [one for one in re.findall(r"`(\{\"kind\".*?\})`", text) if '"result"' not in one]
    read = [
        dialogue_protocol.read_utterance(one.replace("...", '"x"').encode(), UTTERANCE_BYTES)
        for one in shown
    ]
    said = {type(utterance) for utterance in read} | {dialogue_protocol.Unfollow}
    assert said == set(get_args(dialogue_protocol.Utterance)), "each kind is shown"


def test_it_gives_the_right_figures() -> None:
    text = " ".join(PAGE.read_text(encoding="utf-8").split())
    for words in (
        (
            f"One utterance: {UTTERANCE_BYTES // 1024} KiB; "
            f"data in it: {dialogue_protocol.DATA_BYTES // 1024} KiB"
        ),
        (
            f"{dialogue_protocol.TOPICS_A_ROBOT} topics and "
            f"{dialogue_protocol.ROBOT_BYTES // 1024} KiB in all"
        ),
        f"a queue of {inbox.WAITING_AT_MOST} and a pace of {inbox.PACE.per_s:g} a second",
        f"after {inbox.PACE.burst:g} at once",
        f"at most {subscriptions.PAIR_PACE.per_s:g} a second from each robot",
        f"written down, once in {service.SAVE_EVERY_S:g} s",
        f"at most {help_service.CALLS.burst:g} times at once",
        f"after {inbox.HOPS_AT_MOST} hops",
        f"for {inbox.CUT_NS // 60_000_000_000} minutes nothing passes",
        f"{inbox.CONVERSATION.burst:g} at once and one in {1 / inbox.CONVERSATION.per_s:g} s",
        f"at most one message in {digest.EVERY_S:g} s",
        f"for {strategies.IDLE_WITHIN_S / 60:g} min at most",
        f"after {strategies.ANSWER_WITHIN_S:g} s without one",
        f"`for_s`: nobody can accept it later ({dialogue_protocol.HELP_FOR_S:g})",
    ):
        assert words in text, words
    assert all(f":{word}`" in text for word in AMONG)
