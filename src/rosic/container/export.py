"""What is kept, as files that other programs read. The one home of openpyxl."""

from __future__ import annotations

import base64
import io
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import msgspec

from rosic.container import archive_records
from rosic.container import messages as words
from rosic.container.archive_records import Way
from rosic.core.i18n import joined, plain
from rosic.core.language.sanitise import clean
from rosic.errors import ConfigurationError

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from rosic.core.records import Fact

OWN_ID: Final = "rosic"
OWN_NAME: Final = "ROSIC"
UNKNOWN: Final = "None"  # as the paper's program writes a username that is not there
COLUMNS: Final[Mapping[str, int]] = {
    "Number": 9,
    "Time": 24,
    "Direction": 10,
    "Sender ID": 20,
    "Sender Username": 20,
    "Message": 80,
    "Note": 12,
}
THINGS: Final[Mapping[str, int]] = {"Kind": 16, "ID": 24, "Known": 60, "Sealed": 80}
"""Headings of spreadsheets, and how wide their columns are."""
LONGEST_CELL: Final = 32_767
LONGEST_TITLE: Final = 31
"""Of a sheet; both as Excel has them."""

SECRET: Final = frozenset({"totp", "code-key"})
"""Kinds of facts whose letter is a secret: that there is one is said, what it says is not."""

_as_json = msgspec.json.Encoder(order="deterministic", enc_hook=plain).encode


class ArchiveRow(msgspec.Struct, frozen=True, kw_only=True):
    """One line of an archive.

    Attributes:
        until: Of a gap, when it was over; else empty.
    """

    n: int
    time: str
    way: Way
    sender: str
    name: str
    text: str
    note: str = ""
    until: str = ""


read_row = msgspec.json.Decoder(ArchiveRow).decode


# ---- archives ----


def rows(facts: Iterable[Fact]) -> list[ArchiveRow]:
    """Return the entries of an archive, in order; what was erased says so."""
    found = [_row(fact) for fact in facts if fact.kind == archive_records.ENTRY and fact.body]
    return sorted(found, key=lambda row: row.n)


def _row(fact: Fact) -> ArchiveRow:
    entry = archive_records.read_entry(fact.body)
    n, time = archive_records.place_of(fact.key)[1], iso(entry.at_ns)
    if entry.way in {"gap", "lost"}:
        end = iso(entry.until_ns)
        say = words.gap if entry.way == "gap" else words.lost
        return ArchiveRow(
            n=n, time=time, way=entry.way, sender="", name="", text=say(time, end), until=end
        )
    if fact.letter is None:
        erased = words.ERASED
        return ArchiveRow(n=n, time=time, way=entry.way, sender=erased, name=erased, text=erased)
    said = archive_records.read_content(fact.letter.content)
    out = entry.way == "out"
    return ArchiveRow(
        n=n,
        time=time,
        way=entry.way,
        sender=OWN_ID if out else said.account,
        name=OWN_NAME if out else said.name,
        text=said.text,
        note=said.note,
    )


ENDINGS: Final[Mapping[str, str]] = {"text": "txt", "jsonl": "jsonl", "xlsx": "xlsx"}
"""The forms of an export, and how their files end."""


def archive_as(form: str, found: Sequence[ArchiveRow]) -> str | bytes:
    """Return an archive in one of the forms.

    Raises:
        ConfigurationError: No spreadsheet can be made on this computer.
    """
    if form == "xlsx":
        return archive_as_xlsx(found)
    return archive_as_text(found) if form == "text" else archive_as_jsonl(found)


def archive_as_text(found: Sequence[ArchiveRow]) -> str:
    """Return the lines of the paper's Algorithm 6, one for each message.

    A line break inside a message is written as two characters, so that nobody writes a line in
    another's name.
    """
    lines = [_line(row) for row in found]
    gone = found[0].n - 1 if found else 0
    return joined("\n", [*([words.older_gone(gone)] if gone else ()), *lines])


def _line(row: ArchiveRow) -> str:
    if row.way in {"gap", "lost"}:
        return row.text
    return archive_line(row.sender, row.name, row.text)


def archive_line(sender: str, name: str, text: str) -> str:
    """Return one message as line 7 of Algorithm 6 writes it."""
    shown = _one_line(name) or UNKNOWN
    return f"Sender ID: {sender}, Sender Username: {shown}, Message: {_one_line(text)}"


def _one_line(text: str) -> str:
    return clean(text).replace("\n", "\\n")


def archive_as_jsonl(found: Iterable[ArchiveRow]) -> str:
    """Return one JSON object for each entry."""
    return "\n".join(map(row_as_json, found))


def row_as_json(row: ArchiveRow) -> str:
    """Return one entry as a line; `read_row` reads it."""
    return _as_json(row).decode()


def archive_as_xlsx(found: Iterable[ArchiveRow]) -> bytes:
    """Return a workbook of messages.

    Raises:
        ConfigurationError: openpyxl is not installed.
    """
    cells = ((row.n, row.time, row.way, row.sender, row.name, row.text, row.note) for row in found)
    return as_workbook([WorkbookSheet("Messages", COLUMNS, cells)])


class WorkbookSheet(NamedTuple):
    """A sheet of a workbook.

    Attributes:
        title: `LONGEST_TITLE` characters of it are shown.
        columns: Their names, and how wide they are, in characters.
        lines: Cells, as many as columns.
    """

    title: str
    columns: Mapping[str, int]
    lines: Iterable[Sequence[float | str | None]]


def as_workbook(sheets: Iterable[WorkbookSheet]) -> bytes:
    """Return a workbook. Every cell but a number is a text: none is taken for a formula.

    Raises:
        ConfigurationError: openpyxl is not installed.
    """
    try:
        from openpyxl import Workbook  # noqa: PLC0415 - an extra, and slow to load
        from openpyxl.utils import get_column_letter  # noqa: PLC0415 - the same
    except ImportError as missing:
        raise ConfigurationError(words.NO_SPREADSHEET) from missing
    book = Workbook()
    book.remove(book.worksheets[0])
    for one in sheets:
        sheet = book.create_sheet(one.title[:LONGEST_TITLE])
        sheet.append(tuple(one.columns))
        sheet.freeze_panes = "A2"
        for place, width in enumerate(one.columns.values(), start=1):
            sheet.column_dimensions[get_column_letter(place)].width = width
        for number, line in enumerate(one.lines, start=2):
            for place, value in enumerate(line, start=1):
                shown = clean(value)[:LONGEST_CELL] if isinstance(value, str) else value
                cell = sheet.cell(number, place, shown)
                if isinstance(value, str):
                    cell.data_type = "s"
    file = io.BytesIO()
    book.save(file)
    return file.getvalue()


# ---- containers ----


class ContainerSummary(msgspec.Struct, frozen=True):
    """What there is of one kind.

    Attributes:
        size: Bytes, unsealed.
    """

    kind: str
    count: int
    size: int


def summary(container_facts: Iterable[Fact]) -> tuple[ContainerSummary, ...]:
    """Return how much of each kind a container holds, by kind."""
    found: dict[str, tuple[int, int]] = {}
    for fact in container_facts:
        count, size = found.get(fact.kind, (0, 0))
        found[fact.kind] = (count + 1, size + len(fact.letter.content if fact.letter else b""))
    return tuple(ContainerSummary(kind, *found[kind]) for kind in sorted(found))


class ContainedItem(msgspec.Struct, frozen=True, omit_defaults=True):
    """One thing that a container holds, as far as it can be shown.

    Attributes:
        known: What is written down in the open: ids and numbers.
        sealed: What was sealed, if anything is.
    """

    kind: str
    id: str
    known: Any
    sealed: Any = None


read_thing = msgspec.json.Decoder(ContainedItem).decode


def thing_of(fact: Fact) -> ContainedItem:
    """Return how one thing is shown; of a secret, only that there is one."""
    known = _readable(fact.body)
    if fact.letter is None:
        return ContainedItem(fact.kind, fact.key, known)
    secret = fact.kind in SECRET
    sealed = "(a secret)" if secret else _readable(fact.letter.content)
    return ContainedItem(fact.kind, fact.key, known, sealed)


def container_as(form: str, things: Iterable[ContainedItem]) -> str | bytes:
    """Return what a container holds in one of the forms of an archive.

    Raises:
        ConfigurationError: No spreadsheet can be made on this computer.
    """
    if form == "xlsx":
        return as_workbook([WorkbookSheet("Container", THINGS, map(_cells, things))])
    as_line = _thing_line if form == "text" else thing_as_json
    return "\n".join(map(as_line, things))


def thing_as_json(thing: ContainedItem) -> str:
    """Return one thing as a line; `read_thing` reads it."""
    return _as_json(thing).decode()


def _cells(thing: ContainedItem) -> tuple[str, ...]:
    return thing.kind, thing.id, _shown(thing.known), _shown(thing.sealed)


def _thing_line(thing: ContainedItem) -> str:
    """Return one thing in the manner of the paper's line."""
    cells = zip(THINGS, _cells(thing), strict=True)
    return ", ".join(f"{heading}: {_one_line(cell)}" for heading, cell in cells if cell)


def _shown(value: Any) -> str:  # noqa: ANN401 - whatever was written
    if value is None:
        return ""
    return value if isinstance(value, str) else _as_json(value).decode()


def _readable(content: bytes) -> Any:  # noqa: ANN401 - whatever was written
    """Return what bytes say, as well as it can be found out without whoever wrote them."""
    for decode in (msgspec.msgpack.decode, msgspec.json.decode):
        try:
            value = decode(content)
        except (msgspec.MsgspecError, UnicodeDecodeError):
            continue
        if not isinstance(value, int):  # a short text may pass for a number
            return _plain(value)
    try:
        return content.decode()
    except UnicodeDecodeError:
        return _plain(content)


def _plain(value: Any) -> Any:  # noqa: ANN401 - whatever was written
    """Return a value as JSON can say it."""
    if isinstance(value, bytes):
        return base64.b64encode(value).decode()
    if isinstance(value, dict):
        return {str(_plain(key)): _plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    if isinstance(value, msgspec.msgpack.Ext):
        return _plain(value.data)
    return value


def iso(at_ns: int) -> str:
    """Return a time as computers write it, in UTC: ``2026-11-21T14:02:07.120Z``."""
    said = datetime.fromtimestamp(at_ns / 1e9, UTC).isoformat(timespec="milliseconds")
    return said.replace("+00:00", "Z")
