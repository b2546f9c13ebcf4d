"""What people read about a robot that is added while everything runs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.core.i18n import joined, said
from rosic.core.message import Button
from rosic.gateway.replies import LEAVE, LEAVE_IT

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.core.robot.profile import Profile

SUFFIXES: Final = (".yaml", ".yml")
MAY_NOT: Final = said(
    "Only somebody who may assign tasks and give rights here can add a robot. An admin can."
)
ROLE_FOR_GOOD: Final = said(
    "A robot keeps its role for good, and your own right to give rights ends. Add it without a "
    "role, or let an admin without an end add it. Nothing was changed."
)
TOO_LONG: Final = said("The profile is longer than 128 KiB. Nothing was changed.")
NO_TEXT: Final = said("That file is no UTF-8 text. Nothing was changed.")
CLOSING: Final = said("ROSIC is closing. Nothing was changed.")
ADD: Final = said("Add this robot")
LEFT_STOPPED: Final = said("It was stopped when ROSIC last knew it, and stays stopped.")
STOPPED_MEANWHILE: Final = said("A stop came while it was being added, so it is stopped.")
CHANGED: Final = said("The file has changed since I showed it. Nothing was changed.")


def added(profile: Profile) -> str:
    """Return that a robot is here, and what to call it where its name does not say so."""
    if profile.shown.casefold() == profile.id:
        return said("{robot} is here now.", robot=profile.shown)
    return said("{robot} is here now, as {id}.", robot=profile.shown, id=profile.id)


def speaks(robot: str, role: str) -> str:
    """Return that a robot takes part in what robots say to each other."""
    return said("{robot} may speak with the other robots, as {role}.", robot=robot, role=role)


def no_role(role: str, known: Iterable[str]) -> str:
    """Return that there is no such role."""
    return said(
        "There is no role {role} here. There are: {known}. Nothing was changed.",
        role=role,
        known=", ".join(known),
    )


def is_somebody(robot: str) -> str:
    """Return that a robot, or a person of its name, has a key already."""
    return said(
        "Somebody here is called {id} already, and keeps their key and role. Nothing was changed.",
        id=robot,
    )


def would_add(profile: Profile) -> str:
    """Return what is asked before a robot is added."""
    return said(
        "Add {robot}, as {id}? Whoever may use every robot here may use it at once.",
        robot=profile.shown,
        id=profile.id,
    )


def would_speak(name: str, role: str) -> str:
    """Return whether it is to speak with the other robots, and how it would."""
    if role:
        return said("It may speak with the other robots then, as {role}.", role=role)
    return said(
        "It speaks with no other robot. To let it, say {command}; /role names the roles.",
        command=add_command(name, "ROLE"),
    )


def add_command(name: str, role: str) -> str:
    """Return what asks for a robot, as it is typed."""
    return f"/robot add {name} as {role}" if role else f"/robot add {name}"


def confirm_buttons(name: str, role: str, digest: str) -> tuple[tuple[Button, ...], ...]:
    """Return what answers that."""
    yes = Button(said("Add it"), f"{add_command(name, role)} {digest}")
    return ((yes, Button(LEAVE_IT, LEAVE)),)


def add_button(name: str) -> Button:
    """Return what begins to add the robot of a file that was sent."""
    return Button(ADD, f"/robot add {name}")


def wrong(sentences: Iterable[str]) -> str:
    """Return what is wrong with a profile, each in a line."""
    return joined("\n", (*sentences, said("Nothing was changed.")))


def same_id(robot: str) -> str:
    """Return that an id is taken."""
    return said(
        "A robot is called {id} here already. Give this one another id. Nothing was changed.",
        id=robot,
    )


def retired_id(robot: str) -> str:
    """Return that an id belongs to a robot that is retired or not to be used."""
    return said(
        "{id} is here already, and takes no part now: /robot add {id} takes it in again.",
        id=robot,
    )


def same_title(title: str, robot: str) -> str:
    """Return that a title is taken."""
    return said(
        "{robot} is called {title} already. Give this one another title. Nothing was changed.",
        title=title,
        robot=robot,
    )


def same_namespace(namespace: str, robot: str) -> str:
    """Return that another robot is reached there."""
    return said(
        "{robot} is reached under {namespace} already. Nothing was changed.",
        namespace=namespace,
        robot=robot,
    )


def same_robot(robot: str, newcomer: str, name: str) -> str:
    """Return that a robot is here already, under another id."""
    return said(
        "{newcomer} is the robot that is here as {robot}: both name {name}. Nothing was changed.",
        newcomer=newcomer,
        robot=robot,
        name=name,
    )


def unspeakable(why: str) -> str:
    """Return that people could not tell it from what is here."""
    return said("{why} Nothing was changed.", why=why)


def names_somebody(rule: str, author: str) -> str:
    """Return that a rule may not run as a person."""
    return said(
        "The rule {rule} runs as {person}. Only a robot of the configuration file may name a "
        "person. Nothing was changed.",
        rule=rule,
        person=author,
    )


def names_folders(robot: str) -> str:
    """Return that folders are the operator's business."""
    return said(
        "{robot} names folders of this computer. Only its operator can add it, at the computer "
        "itself. Nothing was changed.",
        robot=robot,
    )


def not_opened(robot: str, why: str) -> str:
    """Return that the link could not be opened."""
    return said("{robot} cannot be reached: {why} Nothing was changed.", robot=robot, why=why)


def not_in_time(robot: str, seconds: float) -> str:
    """Return that opening the link took too long: a link may have to build something first."""
    return said(
        "{robot} was not ready within {seconds:.0f} s. The log says whether something has to be "
        "built first: then say it again. Nothing was changed.",
        robot=robot,
        seconds=seconds,
    )


def broken(robot: str) -> str:
    """Return that opening the link failed in a way that nobody foresaw."""
    return said("{robot} cannot be reached; the log says why. Nothing was changed.", robot=robot)
