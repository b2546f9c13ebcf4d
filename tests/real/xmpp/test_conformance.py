"""XMPP under the rules of all messengers, on a real server."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.testing.messengers import MessengerConformance
from tests.real.xmpp.stage import XmppStage, xmpp_stage

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from tests.real.xmpp.prosody import Prosody


class TestXmpp(MessengerConformance):
    @pytest.fixture
    async def stage(self, prosody: Prosody) -> AsyncIterator[XmppStage]:
        async with xmpp_stage(prosody) as stage:
            yield stage
