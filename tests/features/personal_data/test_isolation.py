"""No decision for one looks into another's container, and a limit touches one alone (I11)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rosic.features.personal_data import operator_view
from tests.features.personal_data.data_gateway import Ward, a_ward
from tests.gateway.place import ADA, BO, VI

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

EVERYBODY = "(everybody)"


class Watched(dict[str, Any]):
    """A table by container that notes whose rows are looked at."""

    def __init__(self, rows: dict[str, Any], seen: set[str]) -> None:
        super().__init__(rows)
        self.seen = seen

    def __getitem__(self, key: str) -> Any:  # noqa: ANN401 - whatever is kept
        self.seen.add(key)
        return super().__getitem__(key)

    def get(self, key: str, default: Any = None) -> Any:  # noqa: ANN401 - whatever is kept
        self.seen.add(key)
        return super().get(key, default)

    def __iter__(self) -> Iterator[str]:
        self.seen.add(EVERYBODY)
        return super().__iter__()

    def values(self) -> Any:  # noqa: ANN401 - as a dict
        self.seen.add(EVERYBODY)
        return super().values()

    def items(self) -> Any:  # noqa: ANN401 - as a dict
        self.seen.add(EVERYBODY)
        return super().items()


def watch(ward: Ward) -> set[str]:
    """Note from now on whose container is looked into: in memory, and on the disk."""
    seen: set[str] = set()
    shelf = ward.shelf
    for holder, names in (
        (shelf, ("_kept", "_quotas", "_sizes")),
        (shelf.lending, ("_by", "_to")),
        (ward.book, ("_set",)),
    ):
        for name in names:
            setattr(holder, name, Watched(getattr(holder, name), seen))
    container_facts = ward.kept.container_facts

    async def noted(container: str) -> Any:  # noqa: ANN401 - passed on
        seen.add(container)
        return await container_facts(container)

    ward.kept.container_facts = noted  # type: ignore[method-assign]
    return seen


async def test_the_watch_sees_who_looks(tmp_path: Path) -> None:
    async with a_ward(tmp_path) as ward:
        await ward.said("data", "bay = four", account=BO)
        seen, bo, vi = watch(ward), ward.id_of(BO), ward.id_of(VI)
        ward.shelf.names(bo, bo)
        await ward.kept.container_facts(vi)
        assert seen == {bo, vi}
        list(ward.shelf._kept.items())
        assert EVERYBODY in seen


async def test_no_decision_for_one_looks_into_another_s_container(tmp_path: Path) -> None:
    async with a_ward(tmp_path) as ward:
        ids = {account: ward.id_of(account) for account in (ADA, BO, VI)}
        for account in ids:
            await ward.said("data", "bay = four", account=account)
            await ward.said("settings", "units imperial", account=account)
        seen = watch(ward)
        await ward.say("omni wave", account=BO, chat=BO)
        await ward.say("omni wave fast", account=BO, chat=BO)
        for verb, rest in (
            ("data", "other = 1"),
            ("data", "omni offset = 0.3"),
            ("data", ""),
            ("settings", ""),
            ("mydata", "export"),
            ("share", "other with Vi"),
            ("shelf", ""),
            ("data", "other ="),
        ):
            await ward.said(verb, rest, account=BO)
        assert ids[BO] in seen
        # Asked what is lent to him, he is told of his own index alone; Vi's is not opened.
        assert seen & {ids[ADA], EVERYBODY} == set()
        assert "offset" in await ward.said("data", "omni", account=VI)


async def test_a_limit_is_changed_for_one_and_no_other_is_read(tmp_path: Path) -> None:
    async with a_ward(tmp_path) as ward:
        for account in (ADA, BO, VI):
            await ward.said("data", "bay = four", account=account)
        bo, seen = ward.id_of(BO), watch(ward)
        await operator_view.limit_container(
            ward.data_context, bo, "operator", names=1, most_bytes=100
        )
        assert seen == {bo}
        seen.clear()
        assert "at most 1 name" in await ward.said("data", "more = 1", account=BO)
        assert seen == {bo}
        assert await ward.said("data", "more = 1", account=VI) == "Data stored."
        assert seen == {bo, ward.id_of(VI)}
