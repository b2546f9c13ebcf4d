"""The security report in words, for admins."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.authoriser.words_entry import lasting

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

CLOCK_BEHIND_S: Final = 2.0
# What is counted, as people read it; another kind is shown as it is.
KINDS: Final = {
    "button-late": "taps on a button that was too old",
    "button-other": "taps on a button that was shown to somebody else",
    "button-used": "taps on a button that was used before",
    "code-again": "own code sent again",
    "code-breaker": "times that joining was paused for all",
    "code-burnt": "codes that were shown in a group before",
    "code-expired": "codes that had expired",
    "code-in-group": "good codes shown in a group",
    "code-locked": "codes from somebody who is locked",
    "code-own": "own invitations sent back",
    "code-paused": "codes during a pause of one account",
    "code-paused-for-all": "codes while joining was paused for all",
    "code-unknown": "codes that never were",
    "code-used": "codes that were used before",
    "code-while-waiting": "codes from somebody who waits for an admin",
    "code-withdrawn": "codes that were taken back",
    "confirm-late": "taps on a question that was settled or too old",
    "confirm-no-right": "taps by somebody who may let nobody in",
    "confirm-own": "people who tried to let themselves in",
    "declined": "people whom an admin did not let in",
    "key-expired": "requests after access had ended",
    "key-revoked": "requests after access was taken back",
    "key-unknown": "requests under a key that never was",
    "locked": "requests by somebody who is locked",
    "no-right": "requests by somebody without the right",
    "stranger": "messages from strangers",
    "too-many": "requests that came too fast",
    "totp-in-group": "phones to be set up in a group",
    "totp-paused": "phone codes during a pause",
    "totp-replayed": "phone codes that were used before",
    "totp-wrong": "phone codes that were wrong",
}


def times(measured: int, p50_s: float | None, p99_s: float | None) -> str:
    """Return how long it takes to recognise somebody."""
    if p50_s is None or p99_s is None:
        return "Authentication: nothing measured yet."
    return (
        f"Authentication: p50 {p50_s * 1e3:.3f} ms, p99 {p99_s * 1e3:.3f} ms, "
        f"over the last {measured}."
    )


def attempts(counts: Mapping[str, int]) -> list[str]:
    """Return the unauthorised attempts by kind."""
    if not counts:
        return ["Unauthorised attempts: none."]
    shown = [f"  {KINDS.get(kind, kind)}: {count}" for kind, count in counts.items()]
    return [f"Unauthorised attempts since the first start: {sum(counts.values())}", *shown]


def locks(found: Sequence[tuple[str, str, float]]) -> list[str]:
    """Return who is locked: name, by whom, for how long."""
    if not found:
        return ["Locked: nobody."]
    return ["Locked:", *(f"  {who}, by {by}, for {lasting(s)} now" for who, by, s in found)]


def endings(found: Sequence[tuple[str, str, float]]) -> list[str]:
    """Return which keys end soon: name, key, in how many seconds."""
    if not found:
        return ["Keys near their end: none."]
    shown = [f"  {who}, key {key}, in {lasting(s)}" for who, key, s in found]
    return ["Keys near their end:", *shown]


def invitations(found: Sequence[tuple[str, str, str, float]]) -> list[str]:
    """Return which invitations are open: what, by whom, id, for how long."""
    if not found:
        return ["Open invitations: none."]
    shown = [f"  {what}, by {by}, {made}, good for {lasting(s)}" for what, by, made, s in found]
    return ["Open invitations:", *shown]


def remarks(waiting: int, behind_s: float) -> list[str]:
    """Return what else an admin should see."""
    lines = []
    if waiting:
        people = "person waits" if waiting == 1 else "people wait"
        lines.append(f"{waiting} {people} for an admin to let them in.")
    if behind_s > CLOCK_BEHIND_S:
        lines.append(
            f"The clock of this machine was set back by {lasting(behind_s)}. "
            "Times go on from the highest one seen, until its owner accepts the new one."
        )
    return lines
