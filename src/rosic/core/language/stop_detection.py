"""Is this a stop? Asked of every message before anything else, and of its raw text.

A false stop is cheap, a missed one is not: whatever is a stop at second glance is one. It needs no
vocabulary, no grammar and no cap of theirs; what the names in it mean is settled afterwards, by
`Vocabulary.to_stop`.
"""

from __future__ import annotations

import re
import unicodedata
from itertools import product
from string import ascii_lowercase, digits, punctuation
from typing import TYPE_CHECKING

from rosic.core.language.sanitise import is_plain, normalised
from rosic.core.language.suggestions import distance

if TYPE_CHECKING:
    from collections.abc import Container


# ---- words and signs ----

# As the first word of a line, any of these stops, whatever follows.
_STRONG = """
    stop halt freeze
    stopp anhalten stehenbleiben
    arrêt arrête arrêtez arrêter arrêtes halte
    detente detén deténgase deténganse
    fermati fermatevi fermare fermate
    stoppen stanna stans stands pysähdy pysäytä
    stoj stůj stój stojte stůjte zatrzymaj zastav zastavit zaustavi ustavi stani
    стоп стой стойте остановись остановить остановите остановитесь
    стій зупинись спри спрете стани стој
    durdur durdurun durun
    σταμάτα σταματήστε στοπ
    állj oprește opriți
    قف قفي قفوا توقف توقفي توقفوا أوقف إيقاف ایست بایست رکو
    עצור עצרי עצרו לעצור סטופ
    रुको रुकें रुकिए रुकिये रोको रोकें रोकिए रुक
    থামো থামুন থাম நிறுத்து நில் ఆపు ఆపండి ఆగు ఆగండి
    停 停止 停下 停下来 停下來 停住 停一下 停吧 停机 停機 停车 停車
    站住 快停 快停下 请停 请停止 請停止
    止まれ とまれ 止めて 止めろ 止まって ストップ 停止して
    停止してください 止まってください 止めてください
    멈춰 멈춰라 멈춰요 멈추세요 멈춰주세요 멈춰줘 멈춤 정지 정지해 정지해줘 스톱 스탑 중지
    dừng ngừng ngưng หยุด berhenti hentikan simama tigil itigil hinto
    sustok apstājies peatu ndal ndalo dayan застани запри тоқта зогс կանգնիր გაჩერდი
    थांबा थांब ਰੁਕੋ રોકો થોભો ನಿಲ್ಲಿಸಿ ನಿಲ್ಲು നിർത്തുക നിർത്തൂ ရပ် ឈប់ ຢຸດ ቁም አቁም
    notaus nothalt notstopp notstop aufhören aufhoeren noodstop nødstopp nødstop nödstopp hätäseis
    sluta przestań přestaň prestaň хватит перестань припини vészleállás
    急停 紧急停止 緊急停止 非常停止 紧急停机 紧急停车 住手 やめて やめろ
    비상정지 긴급정지 그만 그만해
    🛑 ✋ ⛔ ⏹ 🤚 🖐 🚫
"""

# What does so in several words, with what goes along between them.
_PHRASES = """
    not aus, not halt, not stopp, emergency off
    hör auf, hoer auf, hört auf, hoert auf, hören sie auf,
    bleib stehen, bleibt stehen, stehen bleiben,
    parada de emergencia, paro de emergencia, paragem de emergencia
    arresto di emergenza, arresto d emergenza, hou op, houd op, hold op
    nouzové zastavení, аварийная остановка, аварійна зупинка, acil duruş, बंद करो
"""

# Ordinary words besides: they stop alone, or together with names and with what goes along.
_WEAK = "alto para pare parar paren parad parem basta alt fermo ferma stai dur"

# Goes along with a stop without adding to it.
_ALONG = """
    a again and an at btw by can could do e el en et für hey i immediately in is it itself
    just kindly la las le les los moving must need no now of oh ok okay on once pls please
    plz quick quickly right robot robots should so that the them there they this to und
    urgent emergency want we will would y ya yes yo you your bitte sofort jetzt por ahora
    sil vous plait te tout de suite maintenant adesso subito agora lütfen hemen şimdi proszę
    natychmiast somebody someone anybody jemand пожалуйста сейчас немедленно быстро
    请 請 快 立即 马上 今すぐ すぐに ください 지금 제발 당장
"""

_EVERYTHING = """
    all alle alles allemaal everybody everyone everything every whole fleet tous toutes todo todos
    todas tudo tutto tutti wszystko wszystkie vše все всё всех hepsi hepsini herkes 全部 所有 すべて
    全て 모두 전부 सब كل الكل
"""

# What stands right before a stop and makes another word of it, or its opposite.
_UNSAID = """
    bus train tram truck full pit non last next first whistle door not never t dont doesnt didnt
    cant cannot wont nicht nie niemals pas ne jamais nunca não mai niet không đừng не 不 不要 别 別
"""

MISSPELT_OF = ("stop", "halt")

_UNSEEN = re.compile("[\ufe00-\ufe0f\U0001f3fb-\U0001f3ff]")
_RUN = re.compile(r"(.)\1+", re.DOTALL)


def fold_stop(text: str) -> str:
    """Return a text as stop words are compared: small letters, no accents, no variants of signs."""
    decomposed = unicodedata.normalize("NFKD", normalised(text).casefold())
    return _UNSEEN.sub("", "".join([c for c in decomposed if not unicodedata.combining(c)]))


def shorten(word: str) -> str:
    """Return the word with every letter that is repeated said once: ``stooop`` is ``stop``."""
    return _RUN.sub(r"\1", word)


def _folded(words: str) -> frozenset[str]:
    return frozenset(fold_stop(word) for word in words.split())


def _misspelt(word: str) -> set[str]:
    """Return everything one slip of a finger away (left out, put in, swapped, another letter)."""
    letters = ascii_lowercase + digits
    places = range(len(word) + 1)
    pairs = [(word[:i], word[i:]) for i in places]
    out = {a + b[1:] for a, b in pairs if b}
    out |= {a + b[1] + b[0] + b[2:] for a, b in pairs if len(b) > 1}
    for (a, b), c in product(pairs, letters):
        out.add(a + c + b)
        out.add(a + c + b[1:])
    return out - {word}


PHRASES = tuple(
    tuple(fold_stop(word) for word in phrase.split())
    for phrase in _PHRASES.replace("\n", ",").split(",")
    if phrase.strip()
)
BEGINNING = frozenset(phrase[0] for phrase in PHRASES)
"""What each of those begins with."""
# In English it is the opposite of what follows, so it only counts where a line or a name begins it.
DOUBTFUL = "not"
STRONG = _folded(_STRONG) | {"".join(phrase) for phrase in PHRASES}
WEAK = _folded(_WEAK)
STOPPING = STRONG | WEAK
SHORTENED = frozenset(map(shorten, STRONG))
ALONG = _folded(_ALONG)
EVERYTHING = _folded(_EVERYTHING)
UNSAID = _folded(_UNSAID)
MISSPELT = frozenset().union(*map(_misspelt, MISSPELT_OF)) - STOPPING


# ---- whether this is a stop ----
# Asked of every message before anything else, and of its raw text.

# So much of a text is looked at, whatever its length.
LOOKED_AT = 4096
# Of more lines these are: a person who stops begins or ends with it.
FIRST_LINES, LAST_LINES = 96, 32
# A longer line talks about something, unless it begins with a stop or consists of nothing else, as
# far as it is looked at.
LONGEST_LINE = 64
LONGEST_SHOUT = 256
# What ends a clause: whoever shouts stop at the end of a sentence means it.
ENDS = ",;:.!?"
KINDS_KEPT = 4096

_BLANKED = str.maketrans({mark: " " for mark in punctuation if mark not in "_@"})
_MENTION = re.compile(r"@(\w*)\S*")
_TRIPLE = re.compile(r"(\w)\1\1")
_SIGNS = re.compile("([🛑✋⛔⏹🤚🖐🚫])")
# Scripts without spaces, where they meet a robot's name.
_SEAM = re.compile(
    "(?<=[\u2e80-\u9fff\uac00-\ud7af])(?=[a-z0-9_])|(?<=[a-z0-9_])(?=[\u2e80-\u9fff\uac00-\ud7af])"
)


def is_stop_word(word: str) -> bool:
    """Whether a word means stop, so that nothing else may be called so."""
    return fold_stop(word) in STOPPING


def hears_stop(text: str, known: Container[str] = ()) -> tuple[str, ...] | None:
    """Return whom a text stops, or None if it is no stop.

    One line that is a stop makes the whole text one. Takes time linear in the first 4,096
    characters, of 256 in a line and of 128 lines, and none for the rest.

    Args:
        text: Raw, as received; any ``str``.
        known: Names of robots, groups, skills, verbs and choices in small letters
            (`Vocabulary.known`). None of them is taken for a misspelt stop.

    Returns:
        The words said beside the stop, in small letters; ``()`` stops everything.
    """
    head = text[:LOOKED_AT]
    if is_plain(head):
        return _heard_ascii(head.lower(), known)
    heard = [_heard(line, known) for line in lines_of(head)]
    stops = [names for names in heard if names is not None]
    if not stops:
        return None
    return () if () in stops else tuple(dict.fromkeys([name for names in stops for name in names]))


def lines_of(head: str) -> list[str]:
    """Return the lines that are looked at, each once: empty ones and repetitions cost nothing."""
    lines = [line for line in dict.fromkeys(head.splitlines()) if line and not line.isspace()]
    if len(lines) <= FIRST_LINES + LAST_LINES:
        return lines
    return lines[:FIRST_LINES] + lines[-LAST_LINES:]


def _heard_ascii(line: str, known: Container[str]) -> tuple[str, ...] | None:
    """Answer for a line in small ASCII letters; almost every message ends at the first return."""
    if "stop" not in line and "halt" not in line:
        words = line.translate(_BLANKED).split()
        if (
            STOPPING.isdisjoint(words)
            and MISSPELT.isdisjoint(words)
            and BEGINNING.isdisjoint(words)
            and not _TRIPLE.search(line)
            and (len(words) > len("stop") or "".join(words) not in STRONG)
        ):
            return None
    return _heard(line, known)


def _heard(line: str, known: Container[str]) -> tuple[str, ...] | None:
    line = line.strip()
    found = _heard_whole(line, known)
    if found is None and (last := _last_clause(line)):  # watch out, STOP
        found = _heard_whole(last, known)
        return found if found is not None and _all_known(found, known) else None
    return found


def _last_clause(line: str) -> str:
    """Return what is said after the last sign that parts sentences; empty: there is none."""
    parted = max(map(line.rstrip(ENDS).rfind, ENDS))
    return line[parted + 1 :] if parted >= 0 and len(line) - parted <= LONGEST_LINE else ""


def _heard_whole(line: str, known: Container[str]) -> tuple[str, ...] | None:
    words = words_of(_beginning(line), known)
    if not words:
        return None
    if "_" in line:  # /stop_omni
        parted = [[word] if word in known else word.split("_") for word in words]
        words = [word for part in parted for word in part if word]
    folded = [fold_stop(word) for word in words]
    folded = [w if w in STOPPING or not _TRIPLE.search(w) else _unstretched(w) for w in folded]
    if not BEGINNING.isdisjoint(folded):
        words, folded = _phrased(words, folded, known)
    if "".join(folded) in STRONG:  # s t o p
        return ()
    stops = [at for at, word in enumerate(folded) if word in STOPPING]
    if len(line) > LONGEST_LINE and not _is_shout(line, folded, known):
        return None
    if not stops:
        return _heard_misspelt(words, folded, known)
    return _heard_exact(words, folded, stops, known)


def _phrased(
    words: list[str], folded: list[str], known: Container[str]
) -> tuple[list[str], list[str]]:
    """Return the words with what means stop in several of them made one: ``not aus``."""
    raw: list[str] = []
    one: list[str] = []
    at = 0
    while at < len(folded):
        doubted = folded[at] == DOUBTFUL and at > 0 and words[at - 1] not in known
        phrase, end = (folded[at], at + 1) if doubted else _phrase_at(folded, at)
        raw.append(words[at])
        one.append(phrase)
        at = end
    return raw, one


def _phrase_at(folded: list[str], at: int) -> tuple[str, int]:
    """Return the phrase that begins here as one word, and its end; else the word that is here."""
    for phrase in PHRASES:
        end = at
        for word in phrase:
            while at < end < len(folded) and folded[end] != word and folded[end] in ALONG:
                end += 1
            if end == len(folded) or folded[end] != word:
                break
            end += 1
        else:
            return "".join(phrase), end
    return folded[at], at + 1


def _beginning(line: str) -> str:
    """Return what is looked at of a line: whole words, unless it is one."""
    if len(line) <= LONGEST_SHOUT:
        return line
    end = line.rfind(" ", 0, LONGEST_SHOUT + 1)
    return line[: end if end > 0 else LONGEST_SHOUT]


def words_of(line: str, known: Container[str]) -> list[str]:
    """Split a line into words in small letters, each sign a word of its own."""
    if "@" in line:  # /stop@account, or a mention of our account in a group
        line = _MENTION.sub(lambda m: f" {m[1]}" if m[1].lower() in known else " ", line)
    if is_plain(line):
        return line.lower().translate(_BLANKED).split()
    line = _SIGNS.sub(r" \1 ", normalised(line).casefold())
    return _SEAM.sub(" ", line.translate(_KEPT)).split()


class _Kept(dict[int, str]):
    """What each character is in a word: itself, nothing, or the end of the word."""

    def __missing__(self, code: int) -> str:
        if len(self) >= KINDS_KEPT:
            self.clear()
        self[code] = kept = _kept(chr(code))
        return kept


def _kept(character: str) -> str:
    kind = unicodedata.category(character)
    if kind[0] in "LNM" or character == "_" or _SIGNS.match(character):
        return character
    return "" if kind in {"Cc", "Cf", "Cs", "Sk"} and not character.isspace() else " "


_KEPT = _Kept()


def _unstretched(word: str) -> str:
    short = shorten(word)
    return "stop" if short in SHORTENED else word


def _is_shout(line: str, folded: list[str], known: Container[str]) -> bool:
    """Whether a long line is a stop all the same."""
    meaning = [word for word in folded if word not in ALONG and word not in known]
    if not meaning:
        return False
    if meaning[0] in STRONG and len(line) <= LONGEST_SHOUT:
        return True
    return all(word in STOPPING or word in EVERYTHING for word in meaning)


def _is_aside(word: str) -> bool:
    return word in ALONG or word in EVERYTHING or word in STOPPING


def _heard_exact(
    words: list[str], folded: list[str], stops: list[int], known: Container[str]
) -> tuple[str, ...] | None:
    """Decide about a line that has a stop word at the places ``stops``."""
    first = stops[0]
    if first > 0 and folded[first - 1] in UNSAID:
        return None
    others = tuple([w for w, f in zip(words, folded, strict=True) if not _is_aside(f)])
    leads = folded[first] in STRONG and all(w in ALONG or w in known for w in folded[:first])
    if not others or (leads and not EVERYTHING.isdisjoint(folded)):
        return ()
    if leads or len(others) == 1 or _all_known(others, known):
        return others
    return None


def _heard_misspelt(
    words: list[str], folded: list[str], known: Container[str]
) -> tuple[str, ...] | None:
    """Decide about a line without any stop word, where one may be misspelt."""
    meaning = [(w, f) for w, f in zip(words, folded, strict=True) if not _is_aside(f)]
    slips = [w for w, f in meaning if _is_slip(f) and w not in known]
    others = tuple([w for w, _ in meaning if w not in slips])
    if slips and (not others or _all_known(others, known)):
        return others
    if len(meaning) == 1:  # stopomni
        word = meaning[0][1]
        rest = next((word[len(stop) :] for stop in MISSPELT_OF if word.startswith(stop)), "")
        if word in known or not rest:
            return None
        return (rest,) if rest in known else () if _is_aside(rest) else None
    return None


def _is_slip(word: str) -> bool:
    if word.isascii():
        return word in MISSPELT
    return len(word) <= 5 and any(distance(word, stop, 1) <= 1 for stop in MISSPELT_OF)  # noqa: PLR2004


def _all_known(words: tuple[str, ...], known: Container[str]) -> bool:
    return " ".join(words) in known or all(word in known for word in words)
