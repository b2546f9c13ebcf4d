"""What goes on by itself is kept until it has ended, and no longer."""

from __future__ import annotations

import asyncio
import gc
from weakref import ref

from rosic.contracts.background_tasks import BackgroundTasks


async def test_a_task_that_nobody_else_keeps_goes_on_until_it_has_ended() -> None:
    tasks: BackgroundTasks[str] = BackgroundTasks()
    begun = ref(tasks.begin(nobody_elses()))
    await asyncio.sleep(0)
    gc.collect()
    [task] = tasks
    assert begun() is task
    assert await task == "done"
    await asyncio.sleep(0)
    assert not tasks


async def nobody_elses() -> str:
    """Wait for something that nothing but this waits for."""
    waiting: asyncio.Future[str] = asyncio.get_running_loop().create_future()
    asyncio.get_running_loop().call_later(0.01, waiting.set_result, "done")
    return await waiting


async def test_one_that_fails_or_is_cancelled_is_kept_no_longer() -> None:
    tasks: BackgroundTasks[None] = BackgroundTasks()

    async def fails() -> None:
        raise ValueError

    failing, cancelled = tasks.begin(fails()), tasks.begin(asyncio.sleep(60))
    cancelled.cancel()
    found = await asyncio.gather(failing, cancelled, return_exceptions=True)
    assert [type(one) for one in found] == [ValueError, asyncio.CancelledError]
    await asyncio.sleep(0)
    assert not tasks
