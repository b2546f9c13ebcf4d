"""What people read about robots among themselves."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.i18n import joined, said, said_n
from rosic.core.language import clean, inert_text
from rosic.organiser.calendar_messages import length

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.core.robot.dialogue_protocol import Shared

DATA_SHOWN = 120
ALL_SHOWN = 1_500


def data(content: bytes, at_most: int = DATA_SHOWN) -> str:
    """Return what a robot said, inert and cut."""
    text = " ".join(inert_text(bytes(content).decode(errors="replace")).split())
    return f"{text[:at_most]}…" if len(text) > at_most else text


def age(seconds: float) -> str:
    """Return how old something is."""
    if seconds < 1:
        return said("just now")
    return said("{time} ago", time=length(int(seconds)))


# ---- shared data ----


def line(shared: Shared, shown: str, past_s: float) -> str:
    """Return one topic in a list."""
    return said(
        "{robot} · {topic} ({age}): {data}",
        robot=shown,
        topic=shared.topic,
        age=age(past_s),
        data=data(shared.data),
    )


def whole(shared: Shared, shown: str, past_s: float) -> str:
    """Return one topic with all that can be shown."""
    return said(
        "{robot} · {topic} ({age}):\n{data}",
        robot=shown,
        topic=shared.topic,
        age=age(past_s),
        data=data(shared.data, ALL_SHOWN),
    )


def nothing_shared(shown: str) -> str:
    """Return that there is none."""
    return said("{robot} shares nothing now.", robot=shown)


def nobody_shares() -> str:
    """Return that no robot does."""
    return said("No robot that you may see shares anything now.")


def follow_label() -> str:
    """Return what a button says that has something shared said in a chat."""
    return said("Follow")


def following(shown: str, robot: str, topic: str) -> str:
    """Return that a chat follows."""
    if topic:
        return said(
            "From now on you read here what {robot} shares on {topic}. To end it: "
            "/shared {id} {topic} unfollow",
            robot=shown,
            topic=topic,
            id=robot,
        )
    return said(
        "From now on you read here what {robot} shares and says to other robots. To end it: "
        "/shared {id} unfollow",
        robot=shown,
        id=robot,
    )


def not_following(shown: str, topic: str) -> str:
    """Return that a chat follows no more; no topic at all, if none is given."""
    if not topic:
        return said("You read no more here of what {robot} shares.", robot=shown)
    return said(
        "You read no more here of what {robot} shares on {topic}.", robot=shown, topic=topic
    )


def digest_line(text: str, before: int) -> str:
    """Return one line of a digest; ``before`` came since the last one and are not shown."""
    if not before:
        return text
    return joined(" ", (text, said_n("(and {n} before it)", "(and {n} before it)", before)))


def shares(shown: str, topic: str, content: bytes) -> str:
    """Return in a digest what was shared."""
    return said("{robot} shares {topic}: {data}", robot=shown, topic=topic, data=data(content))


def says_to(shown: str, other: str, content: bytes) -> str:
    """Return in a digest what a robot said to another."""
    return said("{robot} to {other}: {data}", robot=shown, other=other, data=data(content))


# ---- too much of it ----


def quiet_label(shown: str) -> str:
    """Return what a button says that silences a robot."""
    return said("Silence {robot}", robot=shown)


def flood(shown: str) -> str:
    """Return that a robot says more than can be taken."""
    return said(
        "{robot} says more to the other robots than I pass on. I take only its newest words; "
        "orders and stops are not held up.",
        robot=shown,
    )


def cut(shown: str, other: str, minutes: str) -> str:
    """Return that two robots answered each other without end."""
    return said(
        "{robot} and {other} answered each other without end. I pass nothing on between them "
        "for {time}.",
        robot=shown,
        other=other,
        time=minutes,
    )


def is_cut(shown: str) -> str:
    """Return to a robot why its words are not passed on."""
    return said("Nothing is passed on between you and {robot} now.", robot=shown)


def quieted(shown: str, name: str, until: str) -> str:
    """Return that somebody has silenced a robot."""
    return said(
        "{robot} is silenced among the robots until {time}, by {name}: I pass on nothing that it "
        "says. It still takes orders and stops.",
        robot=shown,
        time=until,
        name=name,
    )


def heard_again(shown: str) -> str:
    """Return that a robot is heard again."""
    return said("{robot} is heard among the robots again.", robot=shown)


def silent_until() -> str:
    """Return to a robot that nobody hears it."""
    return said("You are silenced for now; a person did that.")


def may_not_quiet(shown: str) -> str:
    """Return who may."""
    return said("Only who may operate {robot} silences it.", robot=shown)


def how_to_quiet() -> str:
    """Return how it is written."""
    return said("Write for example: /quiet omni 10 min, or /quiet omni off")


def quiet_bounds(most_s: int) -> str:
    """Return the bounds of a silence."""
    return said(
        "A robot is silenced for a minute at least, and {most} at most.", most=length(most_s)
    )


# ---- help ----


def asks_for_help(shown: str, what: str, until: str) -> str:
    """Return what whoever may help reads."""
    return said(
        "{robot} asks for help: {what}. It can be accepted until {time}.",
        robot=shown,
        what=inert_text(what),
        time=until,
    )


def i_help() -> str:
    """Return what the button says by which a person helps."""
    return said("I help")


def send(shown: str) -> str:
    """Return what the button says by which a person sends a robot."""
    return said("Send {robot}", robot=shown)


def no_such_help() -> str:
    """Return that a request is not known."""
    return said("I know no such request for help. /assist shows what is open.")


def asks_enough(most: int) -> str:
    """Return that a robot asks for too much at once."""
    return said_n(
        "One request for help is open already.", "{n} requests for help are open already.", most
    )


def calls_often() -> str:
    """Return to a robot that it calls people too often."""
    return said("You ask for help too often; wait a minute.")


def accepted_already(name: str) -> str:
    """Return that somebody else was faster."""
    return said("That was accepted already, by {name}. Nothing was changed.", name=clean(name))


def help_over() -> str:
    """Return that it is too late."""
    return said("That request is over. Nothing was changed.")


def helps_itself() -> str:
    """Return that a robot cannot."""
    return said("A robot cannot help itself. Nothing was changed.")


def helped(asker: str, what: str, by: str, helper: str) -> str:
    """Return who helps whom."""
    if helper and helper != by:
        return said(
            "{helper} helps {robot} ({what}), sent by {name}.",
            helper=helper,
            robot=asker,
            what=inert_text(what),
            name=clean(by),
        )
    return said(
        "{name} helps {robot} ({what}).", name=clean(by), robot=asker, what=inert_text(what)
    )


def no_tasks() -> str:
    """Return that no task was changed, for none are kept."""
    return said("No tasks were changed.")


def tasks_failed() -> str:
    """Return that the tasks could not be adjusted."""
    return said("Their tasks could not be adjusted; please look at both.")


def help_ended(asker: str, what: str) -> str:
    """Return that help is not needed any more."""
    return said("{robot} needs no more help ({what}).", robot=asker, what=inert_text(what))


def help_expired(asker: str, what: str) -> str:
    """Return that nobody has helped."""
    return said(
        "Nobody has accepted to help {robot} ({what}). Please look.",
        robot=asker,
        what=inert_text(what),
    )


def no_help_open() -> str:
    """Return that all is well."""
    return said("No robot asks for help.")


def open_help(ident: str, shown: str, what: str) -> str:
    """Return one open request in a list."""
    return said("{robot} asks for help: {what} (/assist {id})", robot=shown, what=what, id=ident)


def under_way(shown: str, what: str, by: str) -> str:
    """Return one request that somebody has accepted."""
    return said("{robot} is helped by {name}: {what}", robot=shown, name=by, what=what)


def may_not_help(shown: str) -> str:
    """Return that somebody may not."""
    return said("Helping {robot} needs a right you do not have. An admin can give it.", robot=shown)


def may_not_send(shown: str) -> str:
    """Return that somebody may not send this robot."""
    return said("Only who may operate {robot} sends it to help.", robot=shown)


# ---- strategies ----


def strategy_now(shown: str, described: str, others: Sequence[str]) -> str:
    """Return a robot's strategy, and which there are."""
    return said(
        "{robot}: {strategy}. There are: {others}.",
        robot=shown,
        strategy=described,
        others=", ".join(others),
    )


def usual() -> str:
    """Return what it is called when no strategy was given."""
    return said("as usual")


def described(title: str, values: str) -> str:
    """Return a strategy and its values."""
    return said("{strategy} ({values})", strategy=title, values=values) if values else title


def no_strategies(shown: str) -> str:
    """Return that a robot has none."""
    return said("{robot} has no strategies.", robot=shown)


def no_such_strategy(shown: str, named: str, others: Sequence[str]) -> str:
    """Return that a strategy is not declared."""
    return said(
        "{robot} has no strategy called {name}. There are: {others}.",
        robot=shown,
        name=named,
        others=", ".join(others),
    )


def nothing_before(shown: str) -> str:
    """Return that there is no way back."""
    return said("{robot} has had no other strategy before.", robot=shown)


def strategy_taken(shown: str, name: str) -> str:
    """Return that somebody else has the robot."""
    return said("{robot} is {name}'s now. Its strategy was not changed.", robot=shown, name=name)


def strategy_when(shown: str, what: str, *, idle: bool) -> str:
    """Return that a strategy was asked for."""
    if idle:
        return said(
            "{robot}: {strategy}, as soon as it carries out nothing.", robot=shown, strategy=what
        )
    return said(
        "{robot}: {strategy}, now. I say when it has taken it on.", robot=shown, strategy=what
    )


def strategy_acknowledged(shown: str, what: str) -> str:
    """Return that the robot has taken it on, by its own word."""
    return said("{robot} has taken on: {strategy}.", robot=shown, strategy=what)


def strategy_declined(shown: str, what: str, why: str) -> str:
    """Return that the robot has not."""
    return said(
        "{robot} has not taken on {strategy}: {why}. It goes on as before.",
        robot=shown,
        strategy=what,
        why=inert_text(why) or "-",
    )


def strategy_unknown(shown: str, what: str) -> str:
    """Return that nobody knows."""
    return said(
        "{robot} was told to take on {strategy} and has not answered. It may or may not have done "
        "so; please look.",
        robot=shown,
        strategy=what,
    )


def strategy_unheard(shown: str, what: str) -> str:
    """Return that nobody listens there."""
    return said(
        "{robot} does not listen now, so this was not sent: {strategy}.", robot=shown, strategy=what
    )


def strategy_unanswered(shown: str, what: str) -> str:
    """Return that a robot was told, and has not said anything yet."""
    return said(
        "{robot} was told to take on {strategy}, and has not answered.", robot=shown, strategy=what
    )


def strategy_late(shown: str, what: str) -> str:
    """Return that the moment has not come."""
    return said(
        "{robot} was at work the whole time, so {strategy} was not sent.",
        robot=shown,
        strategy=what,
    )


def strategy_replaced(shown: str, what: str) -> str:
    """Return that another one came first."""
    return said("{robot}: {strategy} was not sent, for another came.", robot=shown, strategy=what)


def not_asked() -> str:
    """Return to a robot that it answered something else."""
    return said("You were not asked that, or have answered already.")


def how_to_adjust() -> str:
    """Return how a strategy is written."""
    return said("Write for example: /strategy omni careful speed=0.2 now, or /strategy omni back")
