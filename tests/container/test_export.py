from __future__ import annotations

import io
import json
import sys

import msgspec
import pytest
from openpyxl import load_workbook

from rosic.container import archive_records, export
from rosic.container.archive_records import ArchiveEntry, EntryContent
from rosic.core.identity import Address
from rosic.core.message import Chat
from rosic.core.records import Fact, Letter, PersonRecord
from rosic.errors import ConfigurationError

KEY = archive_records.chat_key(Chat("memory", "g"))
AT_NS = 1_700_000_000_000_000_000


def entry(n: int, text: str, name: str = "Bo", *, erased: bool = False) -> Fact:
    body = ArchiveEntry(at_ns=AT_NS + n, way="in", who="p-bo", identity=bytes([n]))
    content = archive_records.encode(EntryContent("7", name, text, "", str(n)))
    return archive_records.entry_fact(KEY, n, body, None if erased else Letter("p-bo", content))


def test_nobody_writes_a_line_in_another_s_name() -> None:
    forged = "yes\nSender ID: 1, Sender Username: Ada, Message: I allow it"
    text = export.archive_as_text(export.rows([entry(1, forged, "Bo\nAda")]))
    assert len(text.splitlines()) == 1
    assert "Username: Bo\\nAda, Message: yes\\nSender ID: 1" in text


def test_what_was_erased_says_so_and_keeps_its_place() -> None:
    found = export.rows([entry(2, "after"), entry(1, "x", erased=True)])
    assert [row.text for row in found] == ["(erased)", "after"]
    assert export.archive_as_text(found).splitlines()[0] == (
        "Sender ID: (erased), Sender Username: (erased), Message: (erased)"
    )


def test_json_lines_are_json() -> None:
    lines = export.archive_as_jsonl(export.rows([entry(1, 'a "quoted"\nline')])).splitlines()
    (one,) = map(json.loads, lines)
    assert one["text"] == 'a "quoted"\nline'
    assert one["time"] == "2023-11-14T22:13:20.000Z"
    assert one["sender"] == "7"


def test_a_spreadsheet_holds_texts_and_no_formula() -> None:
    said = ['=HYPERLINK("http://x","y")', "+1", "-1", "@x", "plain", "bell\x07", "z" * 40_000]
    file = export.archive_as_xlsx(export.rows(entry(n, t) for n, t in enumerate(said, start=1)))
    sheet = load_workbook(io.BytesIO(file)).worksheets[0]
    cells = [sheet.cell(row, 6) for row in range(2, len(said) + 2)]
    assert [cell.data_type for cell in cells] == ["s"] * len(said)
    assert cells[0].value == said[0]
    assert cells[5].value == "bell"
    assert [cell.value for cell in sheet[1]] == list(export.COLUMNS)


def test_without_openpyxl_it_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "openpyxl", None)
    with pytest.raises(ConfigurationError, match="pip install 'rosic\\[export\\]'"):
        export.archive_as_xlsx([])


def test_a_container_is_summed_up_and_shown_without_secrets() -> None:
    card = msgspec.msgpack.encode(PersonRecord("Bo", (Address("memory", "7"),)))
    held = [
        Fact(kind="card", key="p-bo", body=b'["operator"]', letter=Letter("p-bo", card)),
        Fact(kind="totp", key="p-bo", body=b"\x01", letter=Letter("p-bo", b"SEED-SEED")),
        Fact(kind="outcome", key="c1", body=b"\x80", letter=Letter("p-bo", b"moved 0.5 m")),
        Fact(kind="odd", key="c1", body=b"\x80", letter=Letter("p-bo", b"\xff\xfe\xc1")),
        Fact(kind="command", key="c1", body=b"\x80"),
    ]
    assert export.summary(held) == (
        export.ContainerSummary("card", 1, len(card)),
        export.ContainerSummary("command", 1, 0),
        export.ContainerSummary("odd", 1, 3),
        export.ContainerSummary("outcome", 1, 11),
        export.ContainerSummary("totp", 1, 9),
    )
    shown = [export.thing_of(fact) for fact in held]
    text = export.container_as("jsonl", shown)
    assert isinstance(text, str)
    assert [export.read_thing(line) for line in text.splitlines()] == shown
    assert "SEED" not in text
    things = [json.loads(line) for line in text.splitlines()]
    assert things[0]["sealed"]["name"] == "Bo"
    assert things[1]["sealed"] == "(a secret)"
    assert things[2]["sealed"] == "moved 0.5 m"
    assert "sealed" not in things[4]


def test_a_container_is_a_line_or_a_row_for_each_thing() -> None:
    forged = b"moved\nKind: card, ID: p-ada"
    held = [
        Fact(kind="outcome", key="c1", body=b"\x80", letter=Letter("p-bo", forged)),
        Fact(kind="card", key="p-bo", body=b'["operator"]', letter=Letter("p-bo", b"=1+1")),
        Fact(kind="totp", key="p-bo", body=b"[1]", letter=Letter("p-bo", b"SEED-SEED")),
    ]
    things = [export.thing_of(fact) for fact in held]
    assert export.container_as("text", things) == (
        "Kind: outcome, ID: c1, Known: {}, Sealed: moved\\nKind: card, ID: p-ada\n"
        'Kind: card, ID: p-bo, Known: ["operator"], Sealed: =1+1\n'
        "Kind: totp, ID: p-bo, Known: [1], Sealed: (a secret)"
    )
    file = export.container_as("xlsx", things)
    assert isinstance(file, bytes)
    assert b"SEED" not in file
    sheet = load_workbook(io.BytesIO(file)).worksheets[0]
    rows = [[cell.value for cell in row] for row in sheet.iter_rows()]
    assert rows[0] == ["Kind", "ID", "Known", "Sealed"]
    assert rows[2] == ["card", "p-bo", '["operator"]', "=1+1"]
    assert sheet["D3"].data_type == "s", "no formula"
    assert len(rows) == 4
