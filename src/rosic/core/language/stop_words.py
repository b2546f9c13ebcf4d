"""The words and signs by which people stop something, and those that go along with them."""

from __future__ import annotations

import re
import unicodedata
from itertools import product
from string import ascii_lowercase, digits

from rosic.core.language.sanitise import normalised

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
