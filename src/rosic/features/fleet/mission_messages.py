"""What people read about missions."""

from __future__ import annotations

from itertools import islice
from typing import TYPE_CHECKING, Final

from rosic.core.i18n import joined, said, said_n
from rosic.core.language.sanitise import echo
from rosic.core.message import Button

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence


# ---- pause messages ----

# Sentences about tasks that are paused, cancelled and continued together.

ALL: Final = frozenset(
    {"all", "everything", "it", "that", "this", "now", "please"}
    | {"alle", "alles", "bitte", "jetzt", "lassen", "wieder"}
)
BUTTONS_AT_MOST: Final = 4
NAMED_AT_MOST: Final = 8

CONTINUE = said("Continue")
CANCEL = said("Cancel")
NOTHING_PAUSED = said("Nothing of yours is paused.")
TOO_LATE = said("The time is over by which that was to be begun. Nothing was changed.")


def cancelled(tasks: Sequence[str]) -> str:
    """Return that somebody's tasks were cancelled."""
    return said_n(
        "Task {tasks} is cancelled.",
        "{n} tasks are cancelled: {tasks}.",
        len(tasks),
        tasks=_some(tasks),
    )


def paused(tasks: Sequence[str]) -> str:
    """Return that somebody's tasks are paused, or about to be."""
    return said_n(
        "Task {tasks} is paused; its robot is brought to rest.",
        "{n} tasks are paused, and their robots are brought to rest: {tasks}.",
        len(tasks),
        tasks=_some(tasks),
    )


def went_on(tasks: Sequence[str]) -> str:
    """Return that somebody's tasks go on."""
    return said_n(
        "Task {tasks} goes on.", "{n} tasks go on: {tasks}.", len(tasks), tasks=_some(tasks)
    )


def stay_paused(tasks: Sequence[str]) -> str:
    """Return that somebody's tasks did not go on by a word that may have been meant for others."""
    return said_n(
        "Task {tasks} stays paused until you continue it.",
        "{n} tasks stay paused until you continue them: {tasks}.",
        len(tasks),
        tasks=_some(tasks),
    )


def resume_label(shown: str, tasks: Sequence[str]) -> str:
    """Return the label of the button that resumes a robot which then moves by itself."""
    return said_n(
        "Resume {shown}: task {tasks} goes on",
        "Resume {shown}: {n} tasks go on",
        len(tasks),
        shown=shown,
        tasks=_some(tasks),
    )


def cannot_pause(shown: str) -> str:
    """Return that a robot cannot hold a single command half way."""
    return said("{shown} cannot hold that half way. Cancel it, or stop it.", shown=shown)


def _some(tasks: Sequence[str]) -> str:
    more = ", ..." if len(tasks) > NAMED_AT_MOST else ""
    return ", ".join(tasks[:NAMED_AT_MOST]) + more


# ---- mission messages ----

BETWEEN: Final = " · "
NEVER: Final = said("That time is over. Nothing was done.")
FAULT: Final = said("Something went wrong here. Please look.")
HOW_TO: Final = said(
    "Say which mission, and what: /mission start restock, pause, go, cancel; /missions lists them."
)
NONE: Final = said("There is no mission here. /mission new dance begins one, step by step.")


def no_mission(name: str) -> str:
    """Return that a name means no mission."""
    return said("I know no mission called {name}.", name=echo(name))


def not_running(name: str) -> str:
    """Return that a mission does not run."""
    return said("No mission called {name} is under way.", name=name)


def which(name: str) -> str:
    """Return that a mission runs more than once."""
    return said("{name} is under way more than once. Say which.", name=name)


def nobody_can(number: int, name: str, why: str) -> str:
    """Return that a mission cannot be begun."""
    return said(
        "Nobody of {name} can do task {number} of it. Nothing was begun. {why}",
        name=name,
        number=number,
        why=why,
    )


def started(shown: str, run: str, tasks: int) -> str:
    """Return that a mission is begun."""
    return joined(
        BETWEEN,
        [
            said("{mission} is begun as {run}", mission=shown, run=run),
            said_n("one task", "{n} tasks", tasks),
        ],
    )


def run(name: str, done: int, tasks: int, resting: int) -> str:
    """Return how far a mission is."""
    parts: list[str] = [
        said("{mission}: {done} of {tasks} tasks done", mission=name, done=done, tasks=tasks)
    ]
    if resting:
        parts.append(said_n("one needs a person", "{n} need a person", resting))
    return joined(BETWEEN, parts)


def known(name: str, title: str) -> str:
    """Return one mission that may be started."""
    return said("{name}: {title}", name=name, title=title) if title else name


def leaf(number: int, on: str, steps: Sequence[str], after: Sequence[int]) -> str:
    """Return one task of a mission as it is written down."""
    line = joined("", (f"{number}. {on}: ", "; ".join(steps)))
    if not after:
        return line
    return joined(
        BETWEEN, [line, said("after {tasks}", tasks=", ".join(str(a + 1) for a in after))]
    )


def changed(count: int) -> str:
    """Return how many tasks were changed."""
    return said_n("One task changed.", "{n} tasks changed.", count)


def start_buttons(names: Iterable[str]) -> tuple[tuple[Button, ...], ...]:
    """Return what starts a mission, a button each."""
    return tuple(
        (Button(said("Start {mission}", mission=name), f"/mission start {name}"),)
        for name in islice(names, 5)
    )


def run_buttons(name: str) -> tuple[tuple[Button, ...], ...]:
    """Return what whoever looks after a mission can tap."""
    return (
        (
            Button(said("Pause it"), f"/mission pause {name}"),
            Button(said("Cancel it"), f"/mission cancel {name}"),
        ),
    )


def planned(key: str, name: str, moment: str, *, again: bool) -> str:
    """Return when a mission begins by itself."""
    if again:
        return said(
            "{number}: {mission} begins by itself, next {time}",
            number=key,
            mission=name,
            time=moment,
        )
    return said(
        "{number}: {mission} begins by itself, {time}", number=key, mission=name, time=moment
    )


def could_not_begin_now(why: str) -> str:
    """Return what would keep it from beginning at this moment."""
    return said("Now it could not begin: {why} At its time that is asked again.", why=why)


def off_button(key: str) -> tuple[tuple[Button, ...], ...]:
    """Return what takes a time back."""
    return ((Button(said("Take that back"), f"/mission off {key}"),),)


def too_many_times(most: int) -> str:
    """Return that no more times are taken in."""
    return said("There are {most} such times already. Take some back.", most=most)


def no_time(key: str) -> str:
    """Return that a number means no time."""
    return said("No mission has a time {number}.", number=key)


def not_your_time(name: str) -> str:
    """Return that somebody else has planned it."""
    return said(
        "{name} has planned that, and can take it back, or whoever may assign tasks here.",
        name=name,
    )


def taken_back(name: str) -> str:
    """Return that a mission does not begin by itself any more."""
    return said("{mission} does not begin by itself any more.", mission=name)


def slept_through(name: str) -> str:
    """Return that a time was missed."""
    return said("{mission} should have begun while I did not run. It was left out.", mission=name)


def not_begun(name: str, why: str) -> str:
    """Return that a mission did not begin at its time."""
    return said("{mission} was to begin now, and does not. {why}", mission=name, why=why)


# ---- missions that are put together in a chat ----

NO_DRAFT: Final = said("You put no mission together now. /mission new dance begins one.")
NAME_OF_ONE_WORD: Final = said(
    "A mission is called by one word of up to 24 letters and digits that means nothing else here. "
    "Nothing was begun."
)
NOTHING_TO_SAVE: Final = said("It has no steps yet: type one, as you would say it to the robot.")
MAY_NOT_SHARE: Final = said(
    "Only whoever may assign tasks here saves missions for everybody. It is not saved yet."
)


def name_taken(name: str) -> str:
    """Return that there is such a mission."""
    return said("There is a mission called {name} already. Nothing was changed.", name=echo(name))


def drafts_already(name: str) -> str:
    """Return that somebody puts another one together."""
    return said("You are putting {name} together. Save it or leave it first.", name=name)


def too_many_saved(most: int) -> str:
    """Return that somebody has saved as many as one may."""
    return said(
        "You have saved {most} missions already. /mission forget NAME forgets one.", most=most
    )


def draft(name: str, steps: Sequence[str]) -> str:
    """Return a mission as far as it is put together."""
    head = said("{name}, which you put together. No robot does any of it now:", name=name)
    lines = [joined("", (f"{number}. ", step)) for number, step in enumerate(steps, 1)]
    return joined("\n", (head, *lines, said("Type the next step, as you would say it.")))


def draft_buttons(*, some: bool, shares: bool) -> tuple[tuple[Button, ...], ...]:
    """Return what can be done with a mission that is put together."""
    leave = Button(said("Leave it"), "/mission leave")
    if not some:
        return ((leave,),)
    row = (Button(said("Undo"), "/mission undo"), Button(said("Save"), "/mission save"), leave)
    everybody = (Button(said("Save for everybody"), "/mission share"),)
    return (row, everybody) if shares else (row,)


def left(name: str) -> str:
    """Return that a draft is kept no more."""
    return said("{name} is left. What you type is an order again.", name=name)


def left_long_ago(name: str) -> str:
    """Return that a draft was left lying, so that a line may mean two things."""
    return said(
        "You have not gone on with {name} for half an hour, so it is left, and this line was not "
        "done either. What you type from now on is an order again.",
        name=name,
    )


def draft_full(most: int) -> str:
    """Return that a draft has as many steps as it may."""
    return said("It has {most} steps already. Save it, or undo one.", most=most)


def draft_too_large(most: int) -> str:
    """Return that a draft asks for more than a mission may."""
    return said(
        "A mission has at most {most} tasks, one for each robot of a step. Nothing was added.",
        most=most,
    )


def no_step(said_so: str) -> str:
    """Return that a line is no step."""
    return said("Only orders to robots are steps, and this is none: {line}.", line=echo(said_so))


def saved(name: str, *, everybody: bool) -> str:
    """Return that a mission is saved."""
    if everybody:
        return said("{name} is saved for everybody. What you type is an order again.", name=name)
    return said("{name} is saved, for you. What you type is an order again.", name=name)


def not_saved(name: str) -> str:
    """Return that somebody has saved no such mission."""
    return said("You have saved no mission called {name}.", name=echo(name))


def forgotten(name: str) -> str:
    """Return that a mission is kept no more."""
    return said("{name} is forgotten.", name=name)
