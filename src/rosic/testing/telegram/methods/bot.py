"""The bot itself: identity, updates, webhook, presses, commands and names."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import msgspec

from rosic.testing.telegram import objects
from rosic.testing.telegram.methods.call import ApiResult, Call, Method
from rosic.testing.telegram.parameters import Kind
from rosic.testing.telegram.refusals import QUERY_TOO_OLD, bad_request, too_many
from rosic.testing.telegram.state import MOST_CONNECTIONS, JsonObject
from rosic.testing.telegram.updates import KINDS, Poll

if TYPE_CHECKING:
    from rosic.testing.telegram.world import World

MAX_POLL_S = 50
CLOSE_AFTER_S = 600
MAX_ANSWER = 200
COMMAND = re.compile(r"[a-z0-9_]{1,32}\Z")
MAX_COMMANDS = 100
SCOPES: dict[str, frozenset[str]] = {
    "default": frozenset(),
    "all_private_chats": frozenset(),
    "all_group_chats": frozenset(),
    "all_chat_administrators": frozenset(),
    "chat": frozenset({"chat_id"}),
    "chat_administrators": frozenset({"chat_id"}),
    "chat_member": frozenset({"chat_id", "user_id"}),
}
"""https://core.telegram.org/bots/api#botcommandscope: what each needs beside its type."""

NAMES = {
    "Name": ("name", 64),
    "Description": ("description", 512),
    "ShortDescription": ("short_description", 120),
}


def get_me(world: World, _: Call) -> JsonObject:
    """https://core.telegram.org/bots/api#getme."""
    return {
        **objects.user(world.bot),
        "can_join_groups": True,
        "can_read_all_group_messages": not world.settings.privacy,
        "supports_inline_queries": False,
        "can_connect_to_business": False,
        "has_main_web_app": False,
    }


def log_out(world: World, _: Call) -> bool:
    """https://core.telegram.org/bots/api#logout; from then on nothing works."""
    world.state.log_out()
    return True


def close(world: World, _: Call) -> bool:
    """https://core.telegram.org/bots/api#close: "error 429 in the first 10 minutes"."""
    left_s = world.started_s + CLOSE_AFTER_S - world.clock.now_s()
    if left_s > 0:
        raise too_many(int(left_s) + 1)
    return True


async def get_updates(world: World, call: Call) -> list[JsonObject]:
    """https://core.telegram.org/bots/api#getupdates; limits out of range are brought into range."""
    args = call.args
    _allow(world, call)
    limit = min(100, max(1, args.integer("limit", 100)))
    timeout_s = min(MAX_POLL_S, max(0, args.integer("timeout")))
    return await world.queue.get(Poll(args.integer("offset"), limit, timeout_s, call.alive))


def _allow(world: World, call: Call) -> None:
    kinds = call.args.array("allowed_updates")
    for kind in kinds or []:
        if kind not in KINDS:
            world.journal.violation(call.method, f"unknown update type {kind!r}")
    world.queue.allow(kinds)


def set_webhook(world: World, call: Call) -> ApiResult:
    """https://core.telegram.org/bots/api#setwebhook. This server never calls the URL."""
    url = call.args.text("url")
    if not url:
        return delete_webhook(world, call)
    if not url.startswith("https://"):
        raise bad_request("bad webhook: An HTTPS URL must be provided for webhook")
    secret = call.args.text("secret_token")
    if secret and not re.fullmatch(r"[A-Za-z0-9_-]{1,256}", secret):
        raise bad_request("secret token contains unallowed characters")
    _allow(world, call)
    if call.args.flag("drop_pending_updates"):
        world.queue.clear()
    world.queue.expel()
    connections = min(100, max(1, call.args.integer("max_connections", MOST_CONNECTIONS)))
    moved = world.state.webhook.set(url, connections, call.args.text("ip_address") or None)
    return ApiResult(True, "Webhook was set" if moved else "Webhook is already set")


def delete_webhook(world: World, call: Call) -> ApiResult:
    """https://core.telegram.org/bots/api#deletewebhook."""
    if call.args.flag("drop_pending_updates"):
        world.queue.clear()
    was_set = world.state.webhook.remove()
    return ApiResult(True, "Webhook was deleted" if was_set else "Webhook is already deleted")


def get_webhook_info(world: World, _: Call) -> JsonObject:
    """https://core.telegram.org/bots/api#webhookinfo."""
    webhook = world.state.webhook
    shown: JsonObject = {
        "url": webhook.url,
        "has_custom_certificate": False,
        "pending_update_count": len(world.queue),
    }
    if webhook.url:
        shown["max_connections"] = webhook.max_connections
        if webhook.ip_address:
            shown["ip_address"] = webhook.ip_address
    if world.state.allowed is not None:
        shown["allowed_updates"] = world.state.allowed
    return shown


def answer_callback_query(world: World, call: Call) -> bool:
    """https://core.telegram.org/bots/api#answercallbackquery: text of 0-200 characters."""
    args = call.args
    query = world.state.queries.get(args.text("callback_query_id"))
    now_s = world.clock.now_s()
    if query is None or now_s - query.pressed_s > world.settings.answer_window_s:
        raise bad_request(QUERY_TOO_OLD)
    if len(args.text("text")) > MAX_ANSWER:
        raise bad_request("MESSAGE_TOO_LONG")
    url = args.text("url")
    if url and not url.startswith(f"https://t.me/{world.bot.username}?start="):
        # Only games and t.me/your_bot?start= may be opened.
        raise bad_request("URL_INVALID")
    answer: JsonObject = {
        "text": args.text("text"),
        "show_alert": args.flag("show_alert"),
        "url": url,
        "cache_time_s": args.integer("cache_time"),
        "time_s": now_s,
    }
    query.answers.append(answer)
    world.journal.add("answered", query_id=query.id, **{**answer, "time_s": now_s})
    return True


def set_my_commands(world: World, call: Call) -> bool:
    """https://core.telegram.org/bots/api#setmycommands."""
    commands = call.args.array("commands")
    if commands is None:
        raise bad_request("can't parse commands JSON object")
    if len(commands) > MAX_COMMANDS:
        raise bad_request("BOT_COMMANDS_TOO_MUCH")
    for command in commands:
        _check_command(command)
    key = _selection(call)
    if commands:
        world.state.commands[key] = commands
    else:
        world.state.commands.pop(key, None)
    return True


def _check_command(command: object) -> None:
    """https://core.telegram.org/bots/api#botcommand: 1-32 of a-z, 0-9, _; description 1-256."""
    if not isinstance(command, dict) or not COMMAND.match(str(command.get("command", ""))):
        raise bad_request("BOT_COMMAND_INVALID")
    if not 1 <= len(str(command.get("description", ""))) <= 256:
        raise bad_request("BOT_COMMAND_DESCRIPTION_INVALID")


def get_my_commands(world: World, call: Call) -> list[JsonObject]:
    """https://core.telegram.org/bots/api#getmycommands: exactly this scope and language."""
    return world.state.commands.get(_selection(call), [])


def delete_my_commands(world: World, call: Call) -> bool:
    """https://core.telegram.org/bots/api#deletemycommands."""
    world.state.commands.pop(_selection(call), None)
    return True


def _selection(call: Call) -> str:
    scope = call.args.object("scope") or {"type": "default"}
    kind = scope.get("type")
    if kind not in SCOPES or not SCOPES[kind] <= set(scope):
        raise bad_request("can't parse BotCommandScope: unsupported type specified")
    language = call.args.text("language_code")
    if language and not re.fullmatch(r"[a-z]{2}", language):
        raise bad_request("LANGUAGE_CODE_INVALID")
    return msgspec.json.encode([sorted(scope.items()), language]).decode()


def set_name(world: World, call: Call) -> bool:
    """https://core.telegram.org/bots/api#setmyname and its two sisters."""
    field, most = NAMES[call.method.removeprefix("setMy")]
    value = call.args.text(field)
    if len(value) > most:
        raise bad_request(f"BOT_{field.upper()}_TOO_LONG")
    world.state.names[f"{field} {call.args.text('language_code')}"] = value
    return True


def get_name(world: World, call: Call) -> JsonObject:
    """https://core.telegram.org/bots/api#getmyname; where a language has none, the general one."""
    field, _ = NAMES[call.method.removeprefix("getMy")]
    own = world.bot.first_name if field == "name" else ""
    plain = world.state.names.get(f"{field} ") or own
    return {field: world.state.names.get(f"{field} {call.args.text('language_code')}") or plain}


SCOPED = {"scope": Kind.OBJECT, "language_code": Kind.TEXT}
METHODS = {
    "getMe": Method({}, get_me),
    "logOut": Method({}, log_out),
    "close": Method({}, close),
    "getUpdates": Method(
        {
            "offset": Kind.INTEGER,
            "limit": Kind.INTEGER,
            "timeout": Kind.INTEGER,
            "allowed_updates": Kind.ARRAY,
        },
        get_updates,
    ),
    "setWebhook": Method(
        {
            "url": Kind.TEXT,
            "certificate": Kind.FILE,
            "ip_address": Kind.TEXT,
            "max_connections": Kind.INTEGER,
            "allowed_updates": Kind.ARRAY,
            "drop_pending_updates": Kind.FLAG,
            "secret_token": Kind.TEXT,
        },
        set_webhook,
    ),
    "deleteWebhook": Method({"drop_pending_updates": Kind.FLAG}, delete_webhook),
    "getWebhookInfo": Method({}, get_webhook_info),
    "answerCallbackQuery": Method(
        {
            "callback_query_id": Kind.TEXT,
            "text": Kind.TEXT,
            "show_alert": Kind.FLAG,
            "url": Kind.TEXT,
            "cache_time": Kind.INTEGER,
        },
        answer_callback_query,
    ),
    "setMyCommands": Method({"commands": Kind.ARRAY, **SCOPED}, set_my_commands),
    "getMyCommands": Method(SCOPED, get_my_commands),
    "deleteMyCommands": Method(SCOPED, delete_my_commands),
    **{
        f"setMy{name}": Method({field: Kind.TEXT, "language_code": Kind.TEXT}, set_name)
        for name, (field, _) in NAMES.items()
    },
    **{f"getMy{name}": Method({"language_code": Kind.TEXT}, get_name) for name in NAMES},
}
