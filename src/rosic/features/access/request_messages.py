"""Every sentence about asking for a right, and about giving one for a while."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.i18n import joined, said
from rosic.core.language.sanitise import quote
from rosic.core.role_names import role_shown
from rosic.organiser.calendar_messages import length

if TYPE_CHECKING:
    from collections.abc import Sequence

# ---- what ----


def thing(skill: str, shown: str) -> str:
    """Return one thing that a robot does: ``grasp on KUKA iiwa``."""
    return said("{skill} on {robot}", skill=skill, robot=shown)


def for_a_time(what: str, lasts_s: int) -> str:
    """Return what is asked for, and for how long."""
    return said("{what}, for {time}", what=what, time=length(lasts_s))


def until(what: str, moment: str) -> str:
    """Return what was given, and until when."""
    return said("{what}, until {moment}", what=what, moment=moment)


# ---- asking ----


def how_to_ask() -> str:
    """Return how to ask."""
    return said(
        "What would you like to do, with which robot, for how long? Write for example: "
        "/ask ROBOT SKILL for 1h"
    )


def no_such_skill(shown: str, word: str) -> str:
    """Return that a robot has no such skill."""
    return said("{robot} has no {word}. Nothing was asked.", robot=shown, word=quote(word))


def may_already(what: str) -> str:
    """Return that somebody has what they ask for."""
    return said("That is yours already: {what}. Nothing was asked.", what=what)


def no_such_right(shown: str) -> str:
    """Return that no role gives a robot as a whole."""
    return said("Say what you would like {robot} to do. Nothing was asked.", robot=shown)


def nobody_gives(what: str, names: Sequence[str]) -> str:
    """Return that nobody can answer.

    Args:
        what: What was asked for.
        names: Of people who have it themselves.
    """
    sentence = said(
        "Nobody here can give you that: {what}. The operator of this place can. Nothing was asked.",
        what=what,
    )
    if not names:
        return sentence
    return joined(" ", (sentence, said("{names} may do it.", names=_either(names))))


def have_asked(names: Sequence[str], what: str, waits_s: int) -> str:
    """Return what whoever asks reads."""
    return said(
        "I have asked {names}: {what}. You hear from me within {wait}.",
        names=_either(names),
        what=what,
        wait=length(waits_s),
    )


def reach_nobody(names: Sequence[str]) -> str:
    """Return that nobody was told."""
    return said("I cannot reach {names} now, so speak to them yourself.", names=_either(names))


def wants(name: str, what: str, limits: str) -> str:
    """Return the question to whoever may give it."""
    question = said("{name} asks for {what}. Do you allow it?", name=name, what=what)
    if not limits:
        return question
    now = said("Without the limit that {name} has now: {limits}.", name=name, limits=limits)
    return joined(" ", (question, now))


# ---- answering ----


def allow_label(time: str, name: str = "") -> str:
    """Return the label of the button that allows it for a time: ``Allow 1 h``."""
    if name:
        return said("Allow {name} {time}", name=name, time=time)
    return said("Allow {time}", time=time)


def allow_today_label(name: str = "") -> str:
    """Return the label of the button that allows it until midnight."""
    return said("Allow {name} today", name=name) if name else said("Allow today")


def is_something_else(name: str) -> str:
    """Return that what somebody was asked about is not what it was."""
    return said(
        "The roles or robots that {name} asked about have changed since, so that was not given. "
        "{name} can ask again.",
        name=name,
    )


def ask_anew(what: str) -> str:
    """Return the same to whoever asked."""
    return said(
        "What you asked for is void: {what}. The roles or robots, or ROSIC itself, have changed "
        "since. Ask again if you still want it.",
        what=what,
    )


def no_label(name: str = "") -> str:
    """Return the label of the third button."""
    return said("Not {name}", name=name) if name else said("No")


def allowed(name: str, what: str) -> str:
    """Return what whoever allowed it reads."""
    return said("{name} may now: {what}. They have been told.", name=name, what=what)


def capped() -> str:
    """Return why it is for less time than whoever allowed it said."""
    return said("No longer: your own right to give it ends then.")


def was_allowed(by: str, name: str, what: str) -> str:
    """Return what everybody else reads who was asked."""
    return said("{by} allowed {name}: {what}.", by=by, name=name, what=what)


def you_may(by: str, what: str) -> str:
    """Return what whoever asked reads."""
    return said("{by} allows it. You may now: {what}.", by=by, what=what)


def denied(name: str) -> str:
    """Return what whoever said no reads."""
    return said("{name} is told that you do not allow it.", name=name)


def was_denied(by: str, name: str, what: str) -> str:
    """Return what everybody else reads who was asked."""
    return said("{by} did not allow {name}: {what}.", by=by, name=name, what=what)


def you_may_not(by: str, what: str, again_s: int) -> str:
    """Return what whoever asked reads."""
    return said(
        "{by} does not allow it: {what}. You can ask again in {wait}.",
        by=by,
        what=what,
        wait=length(again_s),
    )


def nobody_answered(what: str, names: Sequence[str]) -> str:
    """Return what whoever asked reads in the end."""
    text = said("Nobody answered in time, so nothing has changed: {what}.", what=what)
    if not names:
        return text
    speak = said("You can ask again, or speak to {names} yourself.", names=_either(names))
    return joined(" ", (text, speak))


def lapsed(name: str, what: str) -> str:
    """Return what everybody reads who was asked and has not answered."""
    return said("{name} does not wait any more: {what}.", name=name, what=what)


def answered_before(by: str, *, allowed: bool) -> str:
    """Return that somebody else was first."""
    if allowed:
        return said("{by} allowed that already. Nothing was done.", by=by)
    return said("{by} said no to that already. Nothing was done.", by=by)


def own_question() -> str:
    """Return that nobody answers their own question."""
    return said("Somebody else has to answer that. Nothing was done.")


def not_yours(names: Sequence[str]) -> str:
    """Return that somebody may not give this, and who can."""
    if not names:
        return said("That is not yours to give. The operator of this place can. Nothing was done.")
    return said("That is not yours to give. {names} can. Nothing was done.", names=_either(names))


def no_access(name: str) -> str:
    """Return that whoever asked is locked or gone."""
    return said("{name} has no access now. Nothing was done.", name=name)


def asks(name: str, what: str) -> str:
    """Return one line of a list about somebody who waits for an answer."""
    return said("{name} · asks for {what}", name=name, what=what)


def you_wait(what: str) -> str:
    """Return one line of ``/me``."""
    return said("You wait for an answer: {what}", what=what)


# ---- buttons that are no good any more ----


def these_wait() -> str:
    """Return what stands above the questions that can be answered."""
    return said("These wait for your answer:")


def still_open() -> str:
    """Return what stands above the questions that can still be answered."""
    return said("That button is no good any more. These still wait for your answer:")


def no_such_length() -> str:
    """Return for how long a right that was asked for can be given."""
    return said(
        "What is asked for is given for half a minute at least and for a week at most. Nothing "
        "was given."
    )


def answer_so(name: str) -> str:
    """Return how the same is said without a button."""
    return said("Or write: /approve {name}, or /decline {name}", name=name)


# ---- giving ----


def how_to_grant(role: str, robot: str) -> str:
    """Return how to give somebody a right."""
    return said(
        "Whom, what, where and for how long? Write for example: /grant NAME {role}{robot} for 2h\n"
        "Without a robot it is good everywhere, without a time until it is taken back. A single "
        "right is written ROBOT:SKILL.",
        role=role_shown(role),
        robot=f" {robot}" if robot else "",
    )


def no_time() -> str:
    """Return that a right for no time is none."""
    return said("A right lasts at least a second. Nothing was done.")


def says_where(scope: str) -> str:
    """Return that a single right names its robot."""
    return said(
        "{scope} says already on which robot, so name no other. Nothing was done.", scope=scope
    )


def give_label() -> str:
    """Return the label of the button that gives something for good."""
    return said("Give it")


def give_question(name: str, what: str) -> str:
    """Return the question before something is given that does not end."""
    return said("Give {name} for good: {what}?", name=name, what=what)


def gave(name: str, what: str) -> str:
    """Return what whoever gave it reads."""
    return said("{name} has been told: {what}.", name=name, what=what)


def was_given(by: str, what: str) -> str:
    """Return what whoever was given something reads."""
    return said("{by} gave you: {what}.", by=by, what=what)


def was_given_to(by: str, name: str, what: str) -> str:
    """Return what the other admins read."""
    return said("{by} gave {name}: {what}.", by=by, name=name, what=what)


def nothing_done(sentence: str) -> str:
    """Return what is wrong, and that nothing came of it."""
    return said("{sentence} Nothing was done.", sentence=sentence)


def not_to_yourself() -> str:
    """Return that nobody gives themselves anything."""
    return said("Nobody gives a right to themselves. Nothing was done.")


def take_label() -> str:
    """Return the label of the button that takes a right back."""
    return said("Take it back")


def taken(name: str, what: str) -> str:
    """Return what whoever took it back reads."""
    return said("{name} has this no more: {what}. They have been told.", name=name, what=what)


def was_taken(by: str, what: str) -> str:
    """Return what the person reads."""
    return said("{by} took back: {what}.", by=by, what=what)


def gone() -> str:
    """Return that there is nothing to take back."""
    return said("That right has ended already. Nothing was done.")


def has_ended(what: str) -> str:
    """Return what somebody reads whose right has ended by itself."""
    return said("Your right has ended: {what}.", what=what)


def _either(names: Sequence[str]) -> str:
    """Return names in a row: ``Ada, Bo or Cy``."""
    *others, last = names
    if not others:
        return last
    return said("{names} or {last}", names=", ".join(others), last=last)
