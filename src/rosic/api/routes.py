"""The routes of REST: robots, skills, orders, stops, and whatever else a chat could say."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

from litestar import Request, Response, WebSocket, delete, get, post, websocket
from litestar.di import NamedDependency
from litestar.params import FromPath, HeaderParameter, JSONBody, QueryParameter, SkipValidation
from litestar.status_codes import (
    HTTP_200_OK,
    HTTP_201_CREATED,
    HTTP_202_ACCEPTED,
    HTTP_204_NO_CONTENT,
)

from rosic.api.callers import ApiCaller
from rosic.api.context import ApiContext
from rosic.api.events import EventStream
from rosic.api.ordering import CallerRequests
from rosic.api.read_rates import asking_from
from rosic.api.schemas import (
    AnswerOut,
    ChatIn,
    CheckOut,
    IdentityOut,
    OrderIn,
    OrderOut,
    PageMessage,
    RobotOut,
    SignIn,
    SkillOut,
    StopIn,
    StopOut,
)
from rosic.api.stop_reading import StopRequestBody
from rosic.core.identity import PAGE

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.core.secret import Secret

LISTED_AT_MOST = 200
OPEN = "open"
"""Said of a route that answers whoever asks; every other one asks first who that is."""
Api = NamedDependency[SkipValidation[ApiContext]]
Speech = NamedDependency[SkipValidation[CallerRequests]]
Stream = NamedDependency[SkipValidation[EventStream]]
Who = NamedDependency[SkipValidation[ApiCaller]]
Key = Annotated[str, HeaderParameter(name="Idempotency-Key", max_length=128)]


@get("/me", summary="Who am I?", tags=["people"])
async def me(api: Api, caller: Who) -> IdentityOut:
    """Return who asks, with which roles."""
    return api.me(caller)


@get("/robots", summary="The robots that I may see", tags=["robots"])
async def robots(api: Api, caller: Who) -> list[RobotOut]:
    """Return the robots that the caller may see, as they are now."""
    return api.robots(caller)


@get("/robots/{robot:str}", summary="One robot", tags=["robots"])
async def robot(api: Api, caller: Who, robot: FromPath[str]) -> RobotOut:
    """Return one robot as it is now."""
    return api.named_robot(caller, robot)


@get("/robots/{robot:str}/skills", summary="What I may ask of a robot", tags=["robots"])
async def skills(api: Api, caller: Who, robot: FromPath[str]) -> list[SkillOut]:
    """Return the skills that the caller may ask for, with the schemas of their arguments."""
    return api.skills(caller, robot)


@post(
    "/robots/{robot:str}/orders/check",
    status_code=HTTP_200_OK,
    summary="What an order would come to",
    tags=["orders"],
)
async def check_order(
    api: Api, caller: Who, robot: FromPath[str], data: JSONBody[OrderIn]
) -> CheckOut:
    """Return what an order would come to. Nothing is done, counted or written."""
    return api.check(caller, robot, data.skill, data.arguments)


@post(
    "/robots/{robot:str}/orders",
    status_code=HTTP_202_ACCEPTED,
    summary="Give an order",
    tags=["orders"],
)
async def place_order(
    speech: Speech, caller: Who, robot: FromPath[str], data: JSONBody[OrderIn], key: Key = ""
) -> Response[OrderOut]:
    """Give an order. With the same Idempotency-Key it is the same order, and is given once."""
    placed = await speech.place(caller, robot, data, key)
    headers = {"Location": f"/v1/orders/{placed.id}"}
    return Response(placed, status_code=HTTP_202_ACCEPTED, headers=headers)


@get("/orders", summary="The newest orders", tags=["orders"])
async def orders(
    api: Api,
    caller: Who,
    robot: Annotated[str, QueryParameter(name="robot", max_length=64)] = "",
    most: Annotated[int, QueryParameter(name="limit", ge=1, le=LISTED_AT_MOST)] = 50,
) -> list[OrderOut]:
    """Return the newest orders of robots that the caller may see, whoever gave them."""
    return api.orders(caller, robot, most)


@get("/orders/{order:str}", summary="One order", tags=["orders"])
async def order(
    speech: Speech,
    caller: Who,
    order: FromPath[str],
    wait_s: Annotated[float, QueryParameter(name="wait_s", ge=0, le=60)] = 0.0,
) -> OrderOut:
    """Return an order, once it is over or after so many seconds."""
    return await speech.order(caller, order, wait_s)


@post(
    "/orders/{order:str}/cancel",
    status_code=HTTP_202_ACCEPTED,
    summary="End what I have under way with the robot of an order",
    tags=["orders"],
)
async def cancel_order(speech: Speech, caller: Who, order: FromPath[str]) -> AnswerOut:
    """End what the caller has under way with the robot of this order; nothing is latched."""
    return await speech.say(caller, ChatIn(text=f"cancel {speech.robot_of(caller, order)}"))


@post(
    "/stop",
    status_code=HTTP_200_OK,
    summary="Stop robots",
    tags=["stop"],
    request_class=StopRequestBody,
)
async def stop(speech: Speech, caller: Who, data: JSONBody[StopIn]) -> StopOut:
    """Stop robots at once; all that the caller may see, if none is named. They stay stopped.

    A body that is missing, or cannot be read, stops all as well.

    It is an operational stop over a network and no safety function.
    """
    return await speech.stop(caller, data)


@post("/robots/{robot:str}/stop", status_code=HTTP_200_OK, summary="Stop a robot", tags=["stop"])
async def stop_robot(speech: Speech, caller: Who, robot: FromPath[str]) -> StopOut:
    """Stop one robot at once; it stays stopped until somebody who may resumes it."""
    return await speech.stop(caller, StopIn(robots=(robot,)))


@post("/chat", status_code=HTTP_200_OK, summary="Say something", tags=["chat"])
async def say(speech: Speech, caller: Who, data: JSONBody[ChatIn]) -> AnswerOut:
    """Say what could be typed in a chat, or tap a button, and return the first answer."""
    return await speech.say(caller, data)


@get("/chat", summary="My conversation on the page", tags=["chat"])
async def conversation(api: Api, caller: Who) -> list[PageMessage]:
    """Return what was said in the caller's conversation on the page; a program has none."""
    if caller.address.platform != PAGE:
        return []
    said: Sequence[PageMessage] = api.page.conversation(caller.address.account).all()
    return list(said)


@post(
    "/sessions",
    status_code=HTTP_201_CREATED,
    summary="Sign in",
    tags=["sessions"],
    opt={OPEN: True},
)
async def sign_in(
    request: Request[Any, Any, Any], api: Api, data: JSONBody[SignIn]
) -> Response[IdentityOut]:
    """Begin a session with a code from one's own chat: write /signin there."""
    place = asking_from("" if request.client is None else request.client.host)
    token, fact = api.kernel.access.page_sessions.redeem(data.code, place)
    await api.begin_session(fact)
    return signed_in(api, token)


def signed_in(api: ApiContext, token: Secret) -> Response[IdentityOut]:
    """Return the answer that signs a browser in."""
    caller = api.callers.known_by(token, by_cookie=True)
    answer = Response(api.me(caller), status_code=HTTP_201_CREATED)
    answer.set_cookie(
        key=api.callers.cookie,
        value=token.reveal(),
        httponly=True,
        secure=api.settings.is_tls,
        samesite="strict",
        path="/",
    )
    return answer


@delete("/sessions/current", status_code=HTTP_204_NO_CONTENT, summary="Sign out", tags=["sessions"])
async def sign_out(api: Api, caller: Who) -> Response[None]:
    """End the session of this browser."""
    if caller.by_cookie:
        await api.end_session(caller.secret)
    answer: Response[None] = Response(None, status_code=HTTP_204_NO_CONTENT)
    answer.delete_cookie(api.callers.cookie, path="/")
    return answer


@websocket("/events")
async def events(socket: WebSocket[Any, Any, Any], stream: Stream, caller: Who) -> None:
    """Tell what happens, as it happens; see `rosic.api.events`."""
    await stream.serve(socket, caller)


ROUTES = (
    me,
    robots,
    robot,
    skills,
    check_order,
    place_order,
    orders,
    order,
    cancel_order,
    stop,
    stop_robot,
    say,
    conversation,
    sign_in,
    sign_out,
)
