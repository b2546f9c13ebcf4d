"""What an adapter owns stands in its folder, and what is asked of it stands in the contracts."""

from __future__ import annotations

from tests.shape import rules
from tests.shape.test_source import modules

# What somebody types into the assistant of a first start, or reads there: it sets up a bot.
_ASSISTANT = (
    "TELEGRAM",
    '"telegram"',
    "telegram-token.txt",
    "has_telegram",
    "no_telegram",
    "--no-telegram",
    "Telegram",
    "BotFather",
)
SHOWN = {
    "src/rosic/app/setup/init.py": _ASSISTANT,
    "src/rosic/cli/init.py": _ASSISTANT,
    # An example in what is said of a wrong line of rosic.toml.
    "src/rosic/config/gateway_file.py": ("telegram:1001", 'kind = "telegram"'),
}
OTHERS = (
    "src/rosic/core/",
    "src/rosic/contracts/",
    "src/rosic/authoriser/",
    "src/rosic/organiser/",
    "src/rosic/container/",
    "src/rosic/linker/",
    "src/rosic/gateway/",
    "src/rosic/features/",
    "src/rosic/config/",
    "src/rosic/app/",
    "src/rosic/cli/",
    "src/rosic/rendering/",
    "src/rosic/stores/",
    "src/rosic/robots/",
    "src/rosic/messengers/terminal/",
    "src/rosic/messengers/memory.py",
)
FOREIGN = frozenset(
    {
        "element",  # SQLAlchemy: a labelled column
        "sqlite_errorname",  # of sqlite3's errors, from Python 3.11 on
        "tag",  # of some of PyYAML's events
        "CSafeLoader",  # of PyYAML, where it was built with libyaml
    }
)


def test_nothing_of_telegram_stands_outside_its_adapter() -> None:
    assert rules.of_telegram(modules(*OTHERS), SHOWN) == []


def test_what_is_of_telegram_is_found() -> None:
    planted = {
        "src/rosic/gateway/a.py": 'link = f"https://t.me/{bot}?start="\n',
        "src/rosic/gateway/b.py": "text = text.removesuffix('@lab_bot')\n",
        "src/rosic/features/c.py": '"""Ask BotFather."""\nx = 1\n',
        "src/rosic/app/d.py": 'if messenger.platform == "telegram":\n    pass\n',
        "src/rosic/config/gateway_file.py": "telegram:1001 and Telegram\n",
        "src/rosic/app/e.py": "bottom = robot = both\n",
    }
    found = [line.partition(":")[0] for line in rules.of_telegram(planted, SHOWN)]
    assert found == list(planted)[:5]


def test_no_exception_is_left_that_excepts_nothing() -> None:
    texts = modules(*SHOWN)
    assert {p for p in SHOWN if not rules.of_telegram({p: texts[p]}, {})} == set()


def test_no_ability_is_asked_for_by_name() -> None:
    asked = {
        path: text
        for path, text in modules(*OTHERS, "src/rosic/messengers/").items()
        if not path.startswith("src/rosic/robots/ros2/")  # messages of ROS have fields by name
    }
    assert rules.abilities_asked_by_name(asked, FOREIGN) == []


def test_an_ability_that_is_asked_for_by_name_is_found() -> None:
    text = (
        'if hasattr(messenger, "react"):\n    f(getattr(messenger, "turn", None), getattr(a, n))\n'
    )
    assert len(rules.abilities_asked_by_name({"x.py": text}, FOREIGN)) == 2
    assert rules.abilities_asked_by_name({"x.py": 'getattr(e, "tag", None)\n'}, FOREIGN) == []


def test_what_adapters_may_be_asked_for_stands_in_the_contracts() -> None:
    asking = modules("src/rosic/app/", "src/rosic/gateway/", "src/rosic/features/")
    rooms = modules(*(f"src/rosic/{room}/" for room in ("authoriser", "organiser", "container")))
    assert rules.protocols_in(asking | rooms) == []


def test_a_protocol_outside_the_contracts_is_found() -> None:
    text = "@runtime_checkable\nclass Vault(Protocol):\n    pass\n"
    assert rules.protocols_in({"app/x.py": text}) == ["app/x.py: Vault"]
