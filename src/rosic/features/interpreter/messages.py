"""What is said about the interpreter, and what it proposes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.core.i18n import joined, said

if TYPE_CHECKING:
    from collections.abc import Sequence

PROPOSED: Final = said(
    "An interpreter takes that for one of these. It may be wrong; nothing happens until you tap:"
)
SHOW_IT: Final = said("Show it this one")
NEVER: Final = said("Never show it anything")
TURN_ON: Final = said("Let it be shown")
TURN_OFF: Final = said("Turn it off")
NONE_HERE: Final = said(
    "Nobody is asked here what a line may mean: what I do not understand stays here."
)
OFF: Final = said(
    "What I do not understand is shown to nobody. Say /interpreter on if you change your mind."
)
HOW: Final = said("Write /interpreter on or /interpreter off.")


def notice(where: str) -> str:
    """Return what somebody is told before anything of theirs is shown to an interpreter."""
    if not where:
        return said(
            "What I do not understand I can show to an interpreter, a program on the machine that "
            "I run on, which proposes what you may have meant; your line was not shown to it yet. "
            "From your next one on it is, unless you say /interpreter off."
        )
    return said(
        "What I do not understand I can show to an interpreter at {where}, outside this place, "
        "which proposes what you may have meant; your line was not shown to it yet. From your next "
        "one on it is, unless you say /interpreter off.",
        where=where,
    )


def on(where: str) -> str:
    """Return that an interpreter is shown what is not understood."""
    if not where:
        return said(
            "What I do not understand is shown to an interpreter on the machine that I run on: the "
            "line, and the robots and skills that you may use. Say /interpreter off to end that."
        )
    return said(
        "What I do not understand is shown to an interpreter at {where}: the line, and the robots "
        "and skills that you may use. Say /interpreter off to end that.",
        where=where,
    )


def proposed(acts: Sequence[str]) -> str:
    """Return what was proposed: a line for each, with robot and values."""
    return joined("\n", (PROPOSED, *acts))
