# ruff: noqa: PLC0415 - aiogram takes seconds to load, and every worker imports every test
from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest
from telegram.ext import Application, ApplicationBuilder

from rosic.testing.telegram import FakeTelegram, Settings
from tests.testing.telegram.asking import Api, Wall

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from aiogram import Bot

PtbApplication = Application[Any, Any, Any, Any, Any, Any]


@pytest.fixture
def wall() -> Wall:
    return Wall()


@pytest.fixture
async def server(wall: Wall) -> AsyncIterator[FakeTelegram]:
    """Without limits; its clock stands still; the second 409 is not delayed."""
    settings = Settings(conflict_pause_s=0.0)
    async with FakeTelegram(limits=None, settings=settings, wall_s=wall) as running:
        yield running


@pytest.fixture
async def api(server: FakeTelegram) -> AsyncIterator[Api]:
    async with Api(server) as client:
        yield client


@pytest.fixture
def ada(server: FakeTelegram) -> int:
    return server.create_user("Ada", username="ada")


@pytest.fixture
async def ptb(server: FakeTelegram) -> AsyncIterator[PtbApplication]:
    builder = ApplicationBuilder().token(server.token)
    application = builder.base_url(server.api_base).base_file_url(server.file_base).build()
    async with application:
        yield application


@pytest.fixture
async def aiogram_bot(server: FakeTelegram) -> AsyncIterator[Bot]:
    from aiogram import Bot
    from aiogram.client.session.aiohttp import AiohttpSession
    from aiogram.client.telegram import TelegramAPIServer

    session = AiohttpSession(api=TelegramAPIServer.from_base(server.url))
    async with Bot(server.token, session=session) as bot:
        yield bot
