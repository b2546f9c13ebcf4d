"""Nothing is confirmed to Telegram before it is on disk; a stop behind it is seen all the same."""

from __future__ import annotations

import asyncio
from contextlib import suppress
from typing import TYPE_CHECKING

from rosic.messengers.telegram import polling

if TYPE_CHECKING:
    import pytest

    from rosic.testing.telegram import FakeTelegram
    from tests.real.telegram.gateway import Gateway


class Disk:
    """Settles when it is told to."""

    def __init__(self) -> None:
        self.settled = asyncio.Event()

    async def __call__(self, within_s: float) -> bool:
        with suppress(TimeoutError):
            await asyncio.wait_for(self.settled.wait(), within_s)
        return self.settled.is_set()


async def test_what_is_received_and_not_settled_is_not_confirmed(
    server: FakeTelegram, gateway: Gateway, ada: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(polling, "FULL_S", 3_600.0)  # a stop behind them would be fetched after it
    disk = Disk()
    gateway.messenger.settle_with(disk)
    server.backlog(ada, ada, "omni move {n} m", 250, age_s=60)
    async with gateway.running():
        await gateway.hear(100)
        await asyncio.sleep(2 * polling.PEEK_S)
        assert server.pending() == 250
        assert len(gateway.heard) == 100, "more was asked for than may be lost"
        disk.settled.set()
        await gateway.hear(250)
        await gateway.until(lambda: server.pending() == 0)
    assert gateway.texts == [f"omni move {n} m" for n in range(1, 251)]


async def test_a_stop_is_seen_while_a_disk_hangs(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    gateway.messenger.settle_with(Disk())
    server.say(ada, ada, "omni move 1 m")
    async with gateway.running():
        await gateway.hear(1)
        server.say(ada, ada, "stop omni")
        await gateway.hear(2)
        assert server.pending() == 2
    assert gateway.texts[1] == "stop omni"
