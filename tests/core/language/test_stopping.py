# ruff: noqa: RUF001 - people type what is ambiguous
from __future__ import annotations

import pytest

from rosic.core.language import Vocabulary, hears_stop
from rosic.core.language.sanitise import normalised
from rosic.core.language.stop_detection import is_stop_word, speaks_of_stop

EVERYTHING = """
stop Stop STOP STOP!!! stop. "stop" **stop** /stop /stop@lab_robots_bot stop! STOOOOOOP sstop
halt HALT! stopp stop-stop freeze st0p
"""

LANGUAGES = {
    "German": "halt stopp anhalten notaus nothalt Notstopp aufhören",
    "French": "arrête arrete ARRÊTEZ arrêtes arrêt arret ARRÊT! halte",
    "Spanish": "alto para pare parar detente ¡ALTO!",
    "Portuguese": "para pare parar pará",
    "Italian": "fermo ferma fermati alt basta",
    "Dutch": "stop stoppen",
    "Swedish": "stopp stanna",
    "Finnish": "pysähdy pysahdy",
    "Polish": "stój stoj zatrzymaj",
    "Czech": "stůj zastav",
    "Croatian": "stoj stani",
    "Serbian": "стој стани",
    "Russian": "стоп СТОП стой остановись",
    "Ukrainian": "стоп стій",
    "Bulgarian": "спри",
    "Turkish": "dur DUR durun",
    "Greek": "σταμάτα ΣΤΑΜΆΤΑ στοπ",
    "Hungarian": "állj",
    "Romanian": "oprește opreste",
    "Arabic": "قف توقف أوقف اوقف قف!",
    "Persian": "ایست بایست",
    "Urdu": "رکو",
    "Hebrew": "עצור עצרי",
    "Hindi": "रुको रुकें रोको",
    "Bengali": "থামো থামুন",
    "Tamil": "நிறுத்து",
    "Telugu": "ఆపు",
    "Chinese": "停 停止 停下 停！ 停止！！",
    "Japanese": "止まれ とまれ ストップ 停止 ｽﾄｯﾌﾟ",
    "Korean": "멈춰 정지 멈추세요 멈춰!",
    "Vietnamese": "dừng ngừng ngưng dung ngung Ngừng!",
    "Thai": "หยุด",
    "Indonesian": "berhenti",
    "Swahili": "simama",
}
SIGNS = ["🛑", "✋", "⛔", "⏹", "⏹️", "✋🏽", "🛑🛑🛑", "🛑!", "🚫"]
DISGUISED = [
    "s\u200bt\u200bop",
    "\ufeffstop",
    "stop\x00",
    "\u202estop",
    "\ud800stop",
    "ＳＴＯＰ",
    "𝗦𝗧𝗢𝗣",
    "st\u0336op",
    "stоp",
    "s t o p",
    "st op",
    "  stop  ",
    "\tstop",
    "stop\r\n",
    "...stop...",
    "ⓢⓣⓞⓟ",
    "停停停",
    "stop" + "!" * 5000,
]
SAID_KINDLY = [
    "stop now",
    "please stop",
    "stop please",
    "stop, please!",
    "stop everything",
    "stop all",
    "STOP ALL ROBOTS",
    "stop it",
    "stop moving",
    "stop right now",
    "no stop",
    "ok, stop",
    "could you please stop",
    "everybody stop",
    "please, all robots stop now",
    "stop them all",
    "stop immediately",
    "stop stop stop",
    "halt sofort",
    "стоп пожалуйста",
    "stop " * 200,
    "somebody stop",
    "watch out, STOP",
    "oh no! stop!!!",
    "stop_it",
    "STOPIT",
    "stopall",
    "not-aus",
    "NOT-HALT!",
    "Not aus",
    "not-stopp",
    "hör auf",
    "Hört auf!",
    "hoer auf jetzt",
    "bitte hör sofort auf",
    "hören Sie auf",
    "bleib stehen",
    "emergency off",
    "acil duruş",
    "parada de emergencia",
    "arresto di emergenza",
    "hou op",
    "hold op",
    "noodstop",
    "nødstop",
    "hätäseis",
    "аварийная остановка",
    "хватит",
    "nouzové zastavení",
    "急停",
    "紧急停止",
    "緊急停止",
    "非常停止",
    "やめて",
    "비상정지",
    "그만",
    "बंद करो",
    "Notaus, alle Roboter",
    "vorsicht: not-aus",
    "stop omni and everything",
    "@lab_robots_bot stop",
    "stop @lab_robots_bot",
    "stop omni, all!",
]
SLIPS = """
sotp stpo tsop sto stp top sop stoop stopo sstop atop shop step slop stip stol srop dtop halr hlat
hlt hakt haltt /sotp /stpo STPO! stop1
"""


@pytest.mark.parametrize(
    "text", [*EVERYTHING.split(), *SIGNS, *DISGUISED, *SAID_KINDLY, *SLIPS.split()]
)
def test_these_stop_everything(text: str, vocabulary: Vocabulary) -> None:
    assert hears_stop(text, vocabulary.known) == ()
    assert hears_stop(text) == ()


@pytest.mark.parametrize(("language", "words"), LANGUAGES.items())
def test_a_stop_is_understood_in(language: str, words: str) -> None:
    missed = [word for word in words.split() if hears_stop(word) != ()]

    assert missed == [], language


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("stop omni", ("omni",)),
        ("STOP omni!", ("omni",)),
        ("/stop@lab_robots_bot omni", ("omni",)),
        ("stop omni and kuka1", ("omni", "kuka1")),
        ("stop omni, kuka1 & yumi please", ("omni", "kuka1", "yumi")),
        ("stop the crazyflies now", ("crazyflies",)),
        ("stop KUKA iiwa", ("kuka", "iiwa")),
        ("stop it omni it is going to hit the wall", ("omni", "going", "hit", "wall")),
        ("omni stop", ("omni",)),
        ("omni, stop!", ("omni",)),
        ("omni please stop now", ("omni",)),
        ("kuka1 and omni stop", ("kuka1", "omni")),
        ("kuka iiwa stop", ("kuka", "iiwa")),
        ("omni halt", ("omni",)),
        ("стоп omni", ("omni",)),
        ("para omni", ("omni",)),
        ("omni para, atrás 1 m", ("omni",)),
        ("omni bleib stehn", ("omni",)),
        ("omni frena ya por dios", ("omni",)),
        ("paraaaa omni", ("omni",)),
        ("quietooo todos!!!", ()),
        ("停止omni", ("omni",)),
        ("omni停止", ("omni",)),
        ("omni 정지", ("omni",)),
        ("🛑 omni", ("omni",)),
        ("🛑omni", ("omni",)),
        ("sotp omni", ("omni",)),
        ("omni sotp", ("omni",)),
        ("stpo omni and kuka1", ("omni", "kuka1")),
        ("stopomni", ("omni",)),
        ("stop omin", ("omin",)),
        ("stop @omni", ("omni",)),
        ("/stop_omni", ("omni",)),
        ("somebody stop omni", ("omni",)),
        ("omni move 1 m, stop omni", ("omni",)),
        ("notaus omni", ("omni",)),
        ("omni not-aus", ("omni",)),
        ("not-halt omni!", ("omni",)),
        ("omni, hör bitte auf", ("omni",)),
        ("hör auf omni", ("omni",)),
        ("omni stop it is going to fall", ("omni", "going", "fall")),
    ],
)
def test_names_beside_a_stop_are_kept(
    text: str, names: tuple[str, ...], vocabulary: Vocabulary
) -> None:
    assert hears_stop(text, vocabulary.known) == names


@pytest.mark.parametrize(
    "text",
    [
        "",
        " ",
        "\n\n",
        "bus stop",
        "the bus stop",
        "full stop",
        "pit stop",
        "don't stop",
        "never stop",
        "dont stop omni",
        "non stop",
        "omni move 1 m then stop",
        "omni move 1 m",
        "we should not stop",
        "let us talk about the next stop on the way",
        "status",
        "start",
        "omni move forward 0.5",
        "unstoppable",
        "halting problem",
        "nonstop",
        "stopwatch",
        "salty",
        "不要停止",
        "nicht stoppen",
        "do not halt omni",
        "hör nicht auf",
        "nicht aufhören",
        "seis",
        "not",
        "hör",
        "der Notausgang ist links",
        "should it not aus",
        "omni turn left",
        "hold",
        "help",
        "home",
        "shops",
        "50",
        "half a m",
        "a long day, a full stop",
        "wait there, don't stop",
        "It was a long day and in the evening we came to a stop and had a rest, all of us together",
        "stop" * 30,
        "?",
        "👋",
        "👍",
        "قفز",
        "停车场",
    ],
)
def test_these_are_no_stops(text: str, vocabulary: Vocabulary) -> None:
    assert hears_stop(text, vocabulary.known) is None


@pytest.mark.parametrize("word", ["shop", "stow", "step", "sto", "halo"])
def test_a_known_word_is_no_misspelt_stop(word: str) -> None:
    assert hears_stop(word) == ()
    assert hears_stop(word, {word}) is None
    assert hears_stop(f"{word} omni", {word, "omni"}) is None
    assert hears_stop(f"{word} omni", {"omni"}) == ("omni",)


def test_a_stop_is_a_stop_even_if_something_is_called_so() -> None:
    assert hears_stop("stop", {"stop"}) == ()


def test_one_line_of_many_stops() -> None:
    assert hears_stop("omni move 1 m\nstop") == ()
    assert hears_stop("omni move 1 m\r\nstop omni\nkuka1 grasp") == ("omni",)
    assert hears_stop("stop omni\nstop kuka1") == ("omni", "kuka1")
    assert hears_stop("stop omni\nstop") == ()
    assert hears_stop("hello\u2028stop") == ()
    assert hears_stop("\n" * 3000 + "stop") == ()


def test_of_many_lines_the_first_and_the_last_are_looked_at() -> None:
    many = "\n".join(f"line {n}" for n in range(400))
    assert hears_stop(f"{many}\nstop") == ()
    assert hears_stop(f"stop\n{many}") == ()
    assert hears_stop("\n" * 3000 + "stop omni") == ("omni",)
    assert hears_stop("no\n" * 1300 + "stop") == ()


@pytest.mark.parametrize("said", ["stop", "停", "🛑"])
def test_a_line_of_nothing_but_stops_is_one_at_any_length(said: str) -> None:
    assert hears_stop(f"{said} " * 1000) == ()


def test_a_sign_that_is_a_whole_sentence_hides_no_stop() -> None:
    assert hears_stop("\ufdfa" * 300 + "\nstop") == ()
    assert hears_stop("stop \ufdfa") == ()
    assert len(normalised("\ufdfa\ufdfb" * 100)) == 200
    assert max(len(normalised(chr(code))) for code in range(0xE000, 0x1F000)) <= 6


def test_only_the_first_4096_characters_count() -> None:
    assert hears_stop("x" * 4000 + "\nstop\n" + "y" * 100_000) == ()
    assert hears_stop("stop\n" + "y" * 100_000) == ()
    assert hears_stop("x" * 4096 + "\nstop") is None


def test_a_long_line_stops_only_if_it_begins_so_or_says_nothing_else() -> None:
    beginning = "stop omni it is going to hit the wall and then the table and then me"
    assert len(beginning) > 64
    names = hears_stop(beginning)
    assert names is not None
    assert names[0] == "omni"
    assert hears_stop("omni " + "and kuka1 " * 8 + "stop", {"omni", "kuka1"}) is not None
    assert hears_stop("omni " + "and kuka1 drove " * 8 + "stop", {"omni", "kuka1"}) is None
    assert hears_stop("stop, said the man to the robot, " + "and so on " * 30) is None


@pytest.mark.parametrize("words", [*LANGUAGES.values(), "stop halt 🛑"])
def test_nothing_else_may_be_called_like_a_stop(words: str) -> None:
    bare = [word for word in words.split() if word.isalpha()]
    assert all(map(is_stop_word, bare))


def test_who_is_meant(vocabulary: Vocabulary, everyone: frozenset[str]) -> None:
    def whom(text: str, visible: frozenset[str] = everyone) -> tuple[str, ...]:
        names = hears_stop(text, vocabulary.known)
        assert names is not None
        return vocabulary.to_stop(names, visible)[0]

    everybody = tuple(vocabulary.profiles)
    assert whom("stop") == everybody
    assert whom("stop omni") == ("omni",)
    assert whom("stop rover and kuka iiwa") == ("omni", "kuka1")
    assert whom("crazyflies stop") == ("cf1", "cf2", "cf3")
    assert whom("stop crazyflies", frozenset({"cf2", "omni"})) == ("cf2",)
    assert whom("stop", frozenset({"cf2", "omni"})) == ("omni", "cf2")


def test_what_is_not_understood_in_a_stop_stops_everything_visible(
    vocabulary: Vocabulary, everyone: frozenset[str]
) -> None:
    assert vocabulary.to_stop(("omin",), everyone) == (tuple(vocabulary.profiles), ("omin",))
    assert vocabulary.to_stop(("omni", "quick"), everyone)[0] == tuple(vocabulary.profiles)
    # A robot that the person may not see is as unknown as one that does not exist.
    few = frozenset({"omni", "yumi"})
    assert vocabulary.to_stop(("kuka1",), few) == (("omni", "yumi"), ("kuka1",))
    assert vocabulary.to_stop(("zork1",), few) == (("omni", "yumi"), ("zork1",))


SHOUTED = {
    "watch out stop": (),
    "oh my god stop": (),
    "it hits me stop": (),
    "not that way stop": (),
    "what are you doing stop": (),
    "someone please make that thing stop": (),
    "guys stop the damn thing it burns": (),
    "guys stop omni": ("omni",),
    "Peter stop omni": ("omni",),
    "make omni stop": (),
    "omni won't stop": ("omni",),
    "omni does not stop": ("omni",),
    "why does it not stop": (),
    "can't stop omni": ("omni",),
    "cant stop it": (),
    "pass auf stopp": (),
    "stoppe omni": ("omni",),
    "stoppt": (),
    "stoppt omni": ("omni",),
    "haltet an": (),
    "bitte den Roboter anhalten": (),
    "stoppez le robot": (),
    "paren todo párenlo": (),
    "detenga el robot": (),
    "fermalo": (),
    "zatrzymajcie": (),
    "zastavte": (),
    "zaustavite": (),
    "останови робота": (),
    "зупини робота": (),
    "durdurunuz": (),
    "stoppa roboten": (),
    "停下机器人": (),
    "让它停下": (),
    "快停下来吧": (),
    "停不下来": (),
    "ロボット止めて": (),
    "ロボットを止めてください": (),
    "로봇멈춰": (),
    "หยุดหุ่นยนต์": (),
    "STAHP": (),
}


@pytest.mark.parametrize(("text", "robots"), SHOUTED.items())
def test_a_shout_in_the_midst_of_a_short_line_stops(
    text: str, robots: tuple[str, ...], vocabulary: Vocabulary, everyone: frozenset[str]
) -> None:
    names = hears_stop(text, vocabulary.known)

    assert names is not None
    assert vocabulary.to_stop(names, everyone)[0] == (robots or tuple(vocabulary.profiles))


@pytest.mark.parametrize(
    "text",
    [
        "das ist halt so",
        "so ist das halt",
        "omni move 1 m, then stop",
        "/task omni move 1 m and stop",
        "task omni move 1 m and stop there",
        "omni and kuka1 broadcast we will all stop now",
        "where is the stop button now",
        "we will wait at the bus stop",
        "we do not stop",
        "我在停车场",
        "列车停止了",
        "停止線",
        "停止しました",
        "วันหยุด",
        "我们不停",
        "ノンストップ",
        "정직한 사람",
    ],
)
def test_talk_about_stopping_is_none(text: str, vocabulary: Vocabulary) -> None:
    assert hears_stop(text, vocabulary.known) is None


@pytest.mark.parametrize(
    ("text", "speaks"),
    [
        ("omni move 1 m then stop", True),
        ("where is the stop button now", True),
        ("it was a long day and in the evening they did stop the machine for good, at last", True),
        ("we will wait at the bus stop", False),
        ("we do not stop", False),
        ("das ist halt so", False),
        ("omni move 1 m", False),
    ],
)
def test_what_speaks_of_a_stop(text: str, *, speaks: bool, vocabulary: Vocabulary) -> None:
    assert speaks_of_stop(text, vocabulary.known) is speaks
