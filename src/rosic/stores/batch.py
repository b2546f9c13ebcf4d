"""The rows of one group of calls, between the records they are made of and the statements."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rosic.core.identity import CommandId, PrincipalId
    from rosic.core.robot.profile import RobotId
    from rosic.stores.encryption import ContainerKey


class WriteBatch:
    """The rows of one group, table by table; each list is flat, row after row.

    Where one record of the group bears on the row of another, a dict keeps only one: no statement
    may touch a row twice.

    Attributes:
        opened: New commands whose author is to hear of them.
        silent: New commands of which nobody is to hear.
        closed: Commands that need not be told any more.
        struck: Those of them that stand in ``open_lives``.
        below: Up to where the record is sifted with this group; None for no change.
        kept: Commands that sifting finds open.
        facts: What is so, in the order in which it was first said.
        ended: Kinds and keys of facts that were taken back, before those in ``facts`` were said.
        keys: Keys of containers that are new in this group.
    """

    __slots__ = (
        "below",
        "cards",
        "closed",
        "commands",
        "decisions",
        "ended",
        "endings",
        "facts",
        "issued",
        "kept",
        "keys",
        "opened",
        "places",
        "principals",
        "revocations",
        "robots",
        "seeds",
        "selections",
        "silent",
        "stops",
        "struck",
        "tellings",
    )

    def __init__(self) -> None:
        self.commands: list[object] = []
        self.tellings: list[object] = []
        self.stops: list[object] = []
        self.issued: list[object] = []
        self.revocations: list[object] = []
        self.seeds: list[object] = []
        self.struck: list[object] = []
        self.kept: list[object] = []
        self.decisions: list[object] = []
        self.below: int | None = None
        self.endings: dict[int, tuple[object, ...]] = {}
        self.places: dict[int, tuple[object, ...]] = {}
        self.robots: dict[RobotId, tuple[int, int, int]] = {}
        self.principals: dict[PrincipalId, tuple[str, int]] = {}
        self.cards: dict[PrincipalId, tuple[str, bytes]] = {}
        self.selections: dict[tuple[PrincipalId, bytes], str] = {}
        self.facts: dict[tuple[str, str], tuple[object, ...]] = {}
        self.ended: set[tuple[str, str]] = set()
        self.keys: dict[str, ContainerKey] = {}
        self.opened: dict[CommandId, int] = {}
        self.silent: dict[CommandId, int] = {}
        self.closed: dict[CommandId, int] = {}
