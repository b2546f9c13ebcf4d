"""Files handed to a robot's side: one message or one call each, and what the robot says of it."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from rosic.core.i18n import said
from rosic.core.robot.file_transfer import FileForRobot, Receipt
from rosic.errors import RobotOffline, RobotUnreachable
from rosic.robots.ros2.bindings.answers import BindingAnswer, check_fields, note
from rosic.robots.ros2.client.services import wait_until
from rosic.robots.ros2.errors import BadValue, NoAnswer, NotSent
from rosic.robots.ros2.messages.decode import compile_path
from rosic.robots.ros2.messages.encode import to_message

if TYPE_CHECKING:
    from rosic.core.order_gate import OrderGate
    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic.robots.ros2.client.runtime import RosRuntime
    from rosic.robots.ros2.client.services import ServiceLink
    from rosic.robots.ros2.client.topics import MessageStream, Publisher
    from rosic.robots.ros2.messages.decode import FieldReader
    from rosic.robots.ros2.profile import Deliver, Ros2Profile

FOUND_WITHIN_S = 8.0


class FileBinding:
    """Hands files to one robot, one at a time; nothing where its profile says nothing of it."""

    def __init__(self, profile: Ros2Profile, gate: OrderGate) -> None:
        self._shown = profile.shown
        self._gate = gate
        self._deliver: Deliver | None = profile.files.deliver if profile.files else None
        self._one = asyncio.Lock()
        self._cls: RosObject = None
        self._service: ServiceLink | None = None
        self._publisher: Publisher | None = None
        self._receipts: MessageStream | None = None
        self._said: FieldReader | None = None
        self._waiting: tuple[str, asyncio.Future[str]] | None = None

    def types(self) -> set[str]:
        """Return the types that the binding names."""
        deliver = self._deliver
        if deliver is None:
            return set()
        named = (deliver.topic, deliver.service, deliver.receipt)
        return {binding.type for binding in named if binding is not None}

    async def open(self, runtime: RosRuntime) -> None:
        """Open what it needs, and check the fields that the profile names."""
        deliver = self._deliver
        if deliver is None:
            return
        if deliver.service is not None:
            cls = runtime.types.service(deliver.service.type)
            self._cls = cls.Request
            self._answer = BindingAnswer(cls.Response, deliver.service)
            self._said = compile_path(cls.Response, deliver.digest) if deliver.digest else None
            self._service = await runtime.service(deliver.service.name, deliver.service.type)
        elif deliver.topic is not None:
            self._cls = runtime.types.message(deliver.topic.type)
            self._publisher = await runtime.publisher(deliver.topic.name, deliver.topic.type)
        check_fields(self._cls, deliver.sent)
        if (receipt := deliver.receipt) is not None:
            self._said = compile_path(runtime.types.message(receipt.type), receipt.field)
            self._receipts = await runtime.stream(receipt.topic, receipt.type, self._heard)

    async def close(self) -> None:
        """Leave the graph."""
        ends, self._service, self._publisher, self._receipts = (
            (self._service, self._publisher, self._receipts),
            None,
            None,
            None,
        )
        for end in ends:
            if end is not None:
                await end.close()

    async def deliver(self, robot_file: FileForRobot) -> Receipt:
        """Hand one file over; see ``contracts.robot.deliver_of``."""
        deliver = self._deliver
        if deliver is None:
            raise RobotOffline(said("{robot} takes no files.", robot=self._shown))
        values = {field: _value(given, robot_file) for field, given in deliver.sent.items()}
        async with self._one:
            try:
                to_message(self._cls, values)
                if deliver.service is not None:
                    return await self._call(values, deliver.service.timeout_s)
                return await self._publish(values, robot_file)
            except (NotSent, BadValue) as fault:
                raise RobotOffline(self._nothing_sent()) from fault

    async def _call(self, values: dict[str, object], timeout_s: float) -> Receipt:
        link = self._service
        if link is None:
            raise NotSent("The link is closed.")
        await wait_until(link.sought, link.name, FOUND_WITHIN_S)
        self._check_free()
        try:
            answer = await link.call(values, timeout_s=timeout_s)
        except NoAnswer as fault:
            raise RobotUnreachable(self._no_word(timeout_s)) from fault
        succeeded = self._answer.succeeded(answer)
        digest = "" if self._said is None else note(self._said(answer))
        words = self._answer.words(answer)
        return Receipt(
            received=succeeded,
            declined=not succeeded,
            digest=digest,
            words="" if words == digest else words,
        )

    async def _publish(self, values: dict[str, object], robot_file: FileForRobot) -> Receipt:
        publisher, deliver = self._publisher, self._deliver
        if publisher is None or deliver is None:
            raise NotSent("The link is closed.")
        await wait_until(lambda: publisher.listeners > 0, publisher.topic, FOUND_WITHIN_S)
        if (heard := self._receipts) is not None:  # else its side could say so before we listen
            await wait_until(lambda: heard.publishers > 0, heard.topic, FOUND_WITHIN_S)
        self._check_free()
        if deliver.receipt is None:
            publisher.publish(values)
            return Receipt(received=False)
        saying: asyncio.Future[str] = asyncio.get_running_loop().create_future()
        self._waiting = (robot_file.digest.hex(), saying)
        try:
            publisher.publish(values)
            async with asyncio.timeout(deliver.receipt.within_s):
                return Receipt(received=True, digest=await saying)
        except TimeoutError:
            raise RobotUnreachable(self._no_word(deliver.receipt.within_s)) from None
        finally:
            self._waiting = None

    def _heard(self, message: RosObject) -> None:
        """Take what its side says while it is asked; what is no checksum is about nothing."""
        if self._waiting is None or self._said is None:
            return
        said_now = note(self._said(message)).strip().casefold()
        if len(said_now) == len(self._waiting[0]) and not self._waiting[1].done():
            self._waiting[1].set_result(said_now)

    def _check_free(self) -> None:
        """A stop may have come while its side was looked for; nothing is sent to a stopped one."""
        if self._gate.latched:
            raise RobotOffline(
                said("{robot} is stopped. Nothing was sent to it.", robot=self._shown)
            )

    def _nothing_sent(self) -> str:
        return said("{shown} is not there. Nothing was sent.", shown=self._shown)

    def _no_word(self, seconds: float) -> str:
        return said(
            "{shown} has not answered for {timeout_s:g} s.", shown=self._shown, timeout_s=seconds
        )


def _value(given: float | str | bool, robot_file: FileForRobot) -> object:
    if not isinstance(given, str) or given[:1] != "$":
        return given
    return {
        "$name": robot_file.name,
        "$path": robot_file.path,
        "$sha256": robot_file.digest.hex(),
        "$size": robot_file.size,
        "$kind": robot_file.sort,
        "$text": robot_file.content.decode("utf-8", "replace"),
        "$content": robot_file.content,
    }[given]
