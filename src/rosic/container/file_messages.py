"""Every sentence about files that people keep."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.i18n import figure, joined, said, said_n
from rosic.core.language.sanitise import quote
from rosic.core.language.suggestions import listed

if TYPE_CHECKING:
    from collections.abc import Iterable

MB = 1_000_000
KB = 1_000

HOW = said(
    "Send me a photo or a document and I keep it for you, sealed. /files lists what I keep; "
    "/files get NAME, /files delete NAME, /files send NAME to ROBOT, /files from ROBOT."
)
NONE = said("I keep no file of yours. Send me a photo or a document and I keep it, sealed.")
NOT_HERE = said("I cannot take files over this messenger.")
PLACE_FULL = said(
    "There is no room for files here any more. The operator has to make some. Nothing was kept."
)
TOO_MANY_GOING = said("Large files of yours are under way already. Try again when they are there.")
NOT_THROUGH = said("Something went wrong with the file on its way. Try again.")
CHANGED = said("The file changed while I read it, so I have not sent it. Try again.")
TOO_MANY_COMING = said("I am still taking in files of yours. Send this one when they are here.")
DELETE = said("Delete")
PUT = said("Put it there")
LEAVE_IT = said("Leave it")
EMPTY = said("The file is empty. Nothing was kept.")
DAMAGED = said("The file does not read as it was kept. Delete it, and send it again.")
NOT_NOW = said("I cannot write the file down now, so nothing was kept. The operator has to look.")
BROKEN = said("Something went wrong while I took the file in. Nothing was kept. Send it again.")


def amount(count: int) -> str:
    """Return a number of bytes as messengers count them."""
    if count >= MB:
        return figure(f"{count / MB:.1f} MB")
    return f"{count / KB:.0f} KB" if count >= KB else said("{count} bytes", count=count)


def no_such_file(name: str) -> str:
    """Return that somebody has no file of a name."""
    return said("You have no file {name} here.", name=quote(name))


def too_many_files(most: int) -> str:
    """Return that somebody keeps too many files."""
    return said_n(
        "I keep {n} file for each person at most. Delete one first; nothing was kept.",
        "I keep {n} files for each person at most. Delete one first; nothing was kept.",
        most,
    )


def no_room(size: int, left: int) -> str:
    """Return that a file does not find room."""
    return said(
        "The file has {size}, and you have {left} left here. Delete something first; "
        "nothing was kept.",
        size=amount(size),
        left=amount(left),
    )


def unknown(kinds: Iterable[str]) -> str:
    """Return that a file is none of the kinds that are taken."""
    return said(
        "By its content this is none of the kinds that I take ({kinds}). Nothing was kept.",
        kinds=listed(tuple(kinds)),
    )


def coming(size: int, done: int) -> str:
    """Return how far a file has come."""
    if not size:
        return said("Taking the file in: {done} so far.", done=amount(done))
    part = min(100 * done // size, 100)
    return said("Taking the file in: {part} % of {size}.", part=part, size=amount(size))


def kept(name: str, sort: str, size: int, digest: bytes) -> str:
    """Return that a file is kept, and that nothing else was done with it."""
    return said(
        "{name} ({sort}, {size}) is kept for you, sealed. Nothing was done with it.\n"
        "SHA-256 {digest}",
        name=name,
        sort=sort,
        size=amount(size),
        digest=digest.hex(),
    )


def not_whole(name: str) -> str:
    """Return that a file was interrupted by a restart."""
    return said("{name} had not come whole when I was restarted. Send it again.", name=name)


def line(name: str, sort: str, size: int, ago: str, digest: bytes) -> str:
    """Return one line of the list."""
    return said(
        "{name}: {sort}, {size}, {ago}, SHA-256 {digest}...",
        name=name,
        sort=sort,
        size=amount(size),
        ago=ago,
        digest=digest.hex()[:8],
    )


def listing(lines: Iterable[str], used: int, most: int, limits: str) -> str:
    """Return somebody's files."""
    total = said("{used} of {most} used.", used=amount(used), most=amount(most))
    return joined("\n", [said("Your files:"), *lines, total, limits])


def limits(taken: int, given: int) -> str:
    """Return how large files may be in this chat."""
    if not taken:
        return NOT_HERE
    if not given:
        return said("Here I take files of up to {taken}, and send none.", taken=amount(taken))
    return said(
        "Here I take files of up to {taken} and send files of up to {given}.",
        taken=amount(taken),
        given=amount(given),
    )


def none_kept(limits: str) -> str:
    """Return that somebody keeps nothing."""
    return joined(" ", [NONE, limits])


def sending(name: str, size: int, done: int) -> str:
    """Return how far a file has come on its way to a person."""
    part = min(100 * done // size, 100)
    return said("Sending {name}: {part} % of {size}.", name=name, part=part, size=amount(size))


def sent_whole(name: str) -> str:
    """Return that a file is sent."""
    return said("{name} is sent.", name=name)


def handed(name: str, size: int, digest: bytes) -> str:
    """Return what is said with a file that is given back."""
    return said(
        "{name}, {size}, SHA-256 {digest}", name=name, size=amount(size), digest=digest.hex()
    )


def too_large_to_send(name: str, size: int, most: int) -> str:
    """Return that a messenger does not take a file so large."""
    if not most:
        return said("I cannot send files over this messenger.")
    return said(
        "{name} has {size}; I can send files of up to {most} here.",
        name=name,
        size=amount(size),
        most=amount(most),
    )


def deleted(name: str) -> str:
    """Return that a file is gone."""
    return said("{name} is deleted.", name=name)


# ---- robots ----


def to_robot(shown: str) -> str:
    """Return the label of the button that begins to hand a file over."""
    return said("Send it to {robot}", robot=shown)


def put_question(name: str, size: int, digest: bytes, shown: str) -> str:
    """Return the question before a file goes to a robot."""
    return said(
        "Put {name} ({size}) into the inbox of {robot}? The robot's own software may act on it.\n"
        "SHA-256 {digest}",
        name=name,
        size=amount(size),
        robot=shown,
        digest=digest.hex(),
    )


def deliver_question(name: str, size: int, digest: bytes, shown: str) -> str:
    """Return the question before a file is handed to a robot that has no inbox."""
    return said(
        "Hand {name} ({size}) to {robot}? The robot's own software may act on it.\n"
        "SHA-256 {digest}",
        name=name,
        size=amount(size),
        robot=shown,
        digest=digest.hex(),
    )


def putting(name: str, size: int, shown: str, done: int) -> str:
    """Return how far a large file has come on its way to a robot."""
    return said(
        "Handing {name} to {robot}: {part} % of {size}.",
        name=name,
        part=min(100 * done // size, 100),
        size=amount(size),
        robot=shown,
    )


def received(name: str, digest: bytes, shown: str) -> str:
    """Return that the robot's side says that it has the file, and read what was sent."""
    return said(
        "{robot} has received {name}, and its checksum agrees ({digest}...).",
        name=name,
        robot=shown,
        digest=digest.hex()[:8],
    )


def received_unproved(name: str, shown: str) -> str:
    """Return that the robot's side says that it has the file, and nothing of its checksum."""
    return said(
        "{robot} has received {name}. It says no checksum, so whether it read the same, "
        "I cannot tell.",
        name=name,
        robot=shown,
    )


def received_other(name: str, digest: bytes, theirs: str, shown: str) -> str:
    """Return that the robot's side has read something else than was sent."""
    return said(
        "{robot} has received {name}, but read something else: it says {theirs}..., I sent "
        "{digest}... Do not use it there; send it again.",
        name=name,
        robot=shown,
        theirs=quote(theirs[:8]),
        digest=digest.hex()[:8],
    )


def declined(name: str, shown: str) -> str:
    """Return that the robot's side does not take a file."""
    return said("{robot} has not taken {name}.", name=name, robot=shown)


def sent_to(name: str, digest: bytes, shown: str) -> str:
    """Return that a file was published, and that nothing acknowledges."""
    return said(
        "{name} was sent to {robot} ({digest}...). {robot} gives no receipt for files: whether it "
        "has read it, I cannot tell.",
        name=name,
        robot=shown,
        digest=digest.hex()[:8],
    )


def in_its_words(sentence: str, shown: str, theirs: str) -> str:
    """Return what a robot's side said besides, behind a sentence."""
    return joined("\n", [sentence, said("{robot} says: {theirs}", robot=shown, theirs=theirs)])


def lies_there(name: str, shown: str) -> str:
    """Return that a file lies in an inbox, whatever became of handing it over."""
    return said("{name} lies in the inbox of {robot} all the same.", name=name, robot=shown)


def taken_back(sentence: str, name: str, shown: str) -> str:
    """Return why a file was not handed over, and where it lies nevertheless."""
    return joined(" ", [sentence, lies_there(name, shown)])


def perhaps(name: str, shown: str) -> str:
    """Return that nobody knows whether a robot has a file."""
    return said(
        "Whether {robot} has taken {name}, I cannot tell. Nothing is sent again by itself.",
        name=name,
        robot=shown,
    )


def put_there(name: str, digest: bytes, shown: str) -> str:
    """Return that a file lies there, and that nothing more is known."""
    return said(
        "{name} lies in the inbox of {robot}, with its checksum ({digest}...). {robot} gives no "
        "receipt for files: whether it has read it, I cannot tell.",
        name=name,
        robot=shown,
        digest=digest.hex()[:8],
    )


def name_taken(name: str, shown: str) -> str:
    """Return that there is a file of that name, which is never replaced."""
    return said(
        "There is a {name} in the inbox of {robot} already. Nothing was put there.",
        name=name,
        robot=shown,
    )


def takes_none(shown: str) -> str:
    """Return that a robot takes no files."""
    return said("{robot} takes no files.", robot=shown)


def takes_others(shown: str, sort: str, accept: Iterable[str]) -> str:
    """Return that a robot takes files of other kinds."""
    return said(
        "{robot} takes {kinds}, and this is {kind} by its content. Nothing was put there.",
        robot=shown,
        kinds=listed(tuple(accept)),
        kind=sort,
    )


def too_large_for(shown: str, size: int, most: int) -> str:
    """Return that a robot takes smaller files alone."""
    return said(
        "{robot} takes files of up to {most}; this has {size}. Nothing was put there.",
        robot=shown,
        most=amount(most),
        size=amount(size),
    )


def gives_none(shown: str) -> str:
    """Return that a robot gives no files."""
    return said("{robot} gives no files.", robot=shown)


def gives_nothing_now(shown: str) -> str:
    """Return that there is nothing in a robot's outbox."""
    return said("{robot} has no file for you now.", robot=shown)


def gives(shown: str, lines: Iterable[str]) -> str:
    """Return what a robot gives."""
    return joined("\n", [said("Files of {robot}:", robot=shown), *lines])


def given_line(name: str, size: int, ago: str) -> str:
    """Return one line of what a robot gives."""
    return said("{name}: {size}, {ago}", name=name, size=amount(size), ago=ago)


def too_large_line(line: str) -> str:
    """Return a line of what a robot gives that cannot be sent here."""
    return joined(", ", [line, said("too large to send here")])


def no_such_robot(name: str) -> str:
    """Return that there is no robot of a name, as far as they see."""
    return said("You see no robot {robot}.", robot=quote(name))


def is_stopped(shown: str) -> str:
    """Return that nothing is put into the inbox of a stopped robot."""
    return said("{robot} is stopped. Nothing was put there; resume it first.", robot=shown)


def is_taken(shown: str, name: str) -> str:
    """Return that nothing is put into the inbox of a robot that somebody else has."""
    return said("{name} has {robot} now. Nothing was put there.", name=name, robot=shown)
