"""The words that stop, in many languages, and what goes along with them."""

from __future__ import annotations

import re
import unicodedata
from functools import lru_cache
from itertools import product
from string import ascii_lowercase, digits

from rosic.core.language.sanitise import LONGEST_KEPT, WORDS_KEPT, normalised

# As the first word of a line, any of these stops, whatever follows.
_STRONG = """
    stop halt freeze stahp
    stopp stoppt stoppe haltet anhalten stehenbleiben
    arrêt arrête arrêtez arrêter arrêtes arrêtons halte stoppez stopper
    detente detén deténgase deténganse detenga detengan detener detenerse detenlo detenla detenlos
    deténgalo deténganlo párate párense páralo párala páralos párenlo detenha detenham
    fermati fermatevi fermare fermate fermalo fermala fermali fermatelo arrestati arrestate
    stoppen stopt stanna stoppa stans stanse stands standse pysähdy pysähtykää pysäytä pysäyttäkää
    stoj stůj stój stojte stůjte stójcie zatrzymaj zatrzymajcie zatrzymać zastav zastavte zastavit
    zaustavi zaustavite zaustaviti ustavi ustavite stani stanite
    стоп стой стойте остановись остановить остановите остановитесь останови тормози тормозите
    стій стійте зупинись зупинися зупини зупиніть зупиніться зупинити спыні спыніся
    спри спрете спирай стани станите стој заустави зауставите
    durdur durdurun durdurunuz durun durunuz
    σταμάτα σταματήστε σταμάτησε σταματήσετε σταματάτε στοπ
    állj álljon álljatok állítsd állítsa állítsátok oprește opriți oprească
    قف قفي قفوا توقف توقفي توقفوا أوقف أوقفي أوقفوا أوقفه إيقاف ایست بایست بایستید رکو رکیں روکو
    עצור עצרי עצרו לעצור תעצור תעצרי תעצרו סטופ
    रुको रुकें रुकिए रुकिये रोको रोकें रोकिए रोकिये रुक
    থামো থামুন থাম থামাও থামান நிறுத்து நிறுத்துங்கள் நில் நில்லுங்கள் ఆపు ఆపండి ఆగు ఆగండి
    停 停止 停下 停下来 停下來 停住 停一下 停吧 停机 停機 停车 停車
    站住 快停 快停下 请停 请停止 請停止 停不下来 停不下來 停手 打住 别动 別動
    止まれ とまれ 止めて とめて 止めろ とめろ 止まって とまって 停めて ストップ 停止して
    停止しろ 停止せよ 停止しなさい 止まりなさい 止めなさい
    停止してください 止まってください 止めてください
    멈춰 멈춰라 멈춰요 멈추세요 멈추십시오 멈춰주세요 멈춰줘 멈춤 정지 정지해 정지하세요 정지해줘
    스톱 스탑 중지 중지해 중지하세요 세워 세워줘 세워주세요
    dừng ngừng ngưng หยุด berhenti berhentilah hentikan simama simamisha tigil itigil hinto ihinto
    sustok sustokite sustabdyk apstājies apstājieties apturi apturiet peatu peatuge peata
    ndal ndalo ndaloni dayan dayanin dayandir застани запри запрете
    тоқта тоқтаңыз тоқтат зогс зогсоо կանգնիր կանգնեք կանգնեցրու გაჩერდი გაჩერდით გააჩერე გააჩერეთ
    थांबा थांब थांबवा ਰੁਕੋ ਰੋਕੋ રોકો થોભો ನಿಲ್ಲಿಸಿ ನಿಲ್ಲಿಸು ನಿಲ್ಲು
    നിർത്തുക നിർത്തൂ നിൽക്കൂ ရပ် ឈប់ ຢຸດ ቁም አቁም አቁሙ
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
    bleib stehen, bleibt stehen, stehen bleiben, bleib stehn, bleibt stehn, stehn bleiben,
    halte an, haltet an, halten sie an,
    para de, pare de, parem de, deixa de, deje de, deja de,
    parada de emergencia, paro de emergencia, paragem de emergencia
    arresto di emergenza, arresto d emergenza, hou op, houd op, hold op
    nouzové zastavení, аварийная остановка, аварійна зупинка, acil duruş, बंद करो
"""

# Ordinary words besides: they stop alone, or together with names and with what goes along.
_WEAK = """
    alto para pare parar paren parad parem basta alt fermo ferma stai dur
    quieto quieta quietos quietas frena frene frenen frená freno
"""

# Goes along with a stop without adding to it.
_ALONG = """
    a again and an at btw by can could do e el en et für hey i immediately in is it itself
    just kindly la las le les los moving must need no now of oh ok okay on once pls please
    plz quick quickly right robot robots should so that the them there they this to und
    urgent emergency want we will would y ya yes yo you your bitte sofort jetzt por ahora
    gente por dios pelo amor de deus já ja
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
    cant cannot wont nicht nie niemals pas ne jamais nunca não mai niet không đừng не 不
    不要 别 別
"""

# As strong as the others at the beginning of a line, but words of every day in the midst of one:
# ``das ist halt so``, ``ich halte es``, ``a stand stands``, ``hinto``.
_EVERYDAY = """
    halt halte haltet freeze stans stands dayan arrêt durun stani hinto dừng ngừng ngưng
    detener simama sluta prestaň хватит 停 그만 세워
"""

# What stands right before a stop without taking anything from it, but makes it no shout either:
# ``we came to a stop``, ``omni move 1 m then stop``.
_TOLD = "a then dann danach puis ensuite luego entonces depois poi then затем потом dan daarna"

HAD_TO = ["had", "to"]

# What stands right behind a stop and makes a thing of it.
_THINGS = """
    sign signs button buttons word words light lights codon loss watch watches line lines
    schild schilder taste knopf wort wörter uhr linie
"""

# Something does not stop though it should: whoever says so wants it to. ``Do not stop`` is none.
_FAILS = "will wont won does doesnt doesn can cant cannot did didnt didn could couldnt couldn isnt"

# Lines that begin with one of these hand a text on, or keep it for later.
_FREE_TEXT = """
    task tasks aufgabe aufgaben mission broadcast rundruf say sag sage wish wunsch book buche buchen
"""

MISSPELT_OF = ("stop", "halt")

# Scripts that are written without blanks, or often so; of a single sign no word is made.
_UNSPACED = re.compile(
    "[\u2e80-\u9fff\uac00-\ud7af]{2,}|[\u0e00-\u0eff]{2,}|[\u1000-\u109f\u1780-\u17ff]{2,}"
)
# What says the opposite right before such a word, or makes another one of it: nonstop, a holiday.
_NEGATED = "不要 别 別 勿 不用 不必 不 ノン 논 วัน อย่า ไม่"
# What such a word goes on with if it means something else: a car park, a stop line, has stopped.
_GOES_ON = """
    场 場 位 库 庫 费 費 区 區 点 點 站 牌 线 線 坪 证 証 键 鍵 了 过 過
    中 した しま してい され 条件 ウォッチ ボタン
    됨 선 된 워치 버튼 พัก
"""

_UNSEEN = re.compile("[\ufe00-\ufe0f\U0001f3fb-\U0001f3ff]")
_RUN = re.compile(r"(.)\1+", re.DOTALL)


def fold_stop(text: str) -> str:
    """Return a text as stop words are compared: small letters, no accents, no variants of signs."""
    if text.isascii():
        return text.lower()
    return _fold_again(text) if len(text) <= LONGEST_KEPT else _fold(text)


def _fold(text: str) -> str:
    decomposed = unicodedata.normalize("NFKD", normalised(text).casefold())
    marks = {ord(sign): None for sign in set(decomposed) if unicodedata.combining(sign)}
    return _UNSEEN.sub("", decomposed.translate(marks) if marks else decomposed)


_fold_again = lru_cache(maxsize=WORDS_KEPT)(_fold)
"""The same word is folded for each thing that is looked for, and stands in many lines."""


def shorten(word: str) -> str:
    """Return the word with every letter that is repeated said once: ``stooop`` is ``stop``."""
    return _RUN.sub(r"\1", word)


def folded_words(words: str) -> frozenset[str]:
    """Return the words of a text as they are compared."""
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
STRONG = folded_words(_STRONG) | {"".join(phrase) for phrase in PHRASES}
WEAK = folded_words(_WEAK)
STOPPING = STRONG | WEAK
UNSTRETCHED = {shorten(word): word for words in (WEAK, STRONG) for word in sorted(words)}
"""What stops, by how it is written with every letter once: ``paraaa`` is ``para``."""
ALONG = folded_words(_ALONG)
EVERYTHING = folded_words(_EVERYTHING)
UNSAID = folded_words(_UNSAID)
SHOUTED = STRONG - folded_words(_EVERYDAY)
"""What stops in the midst of a short line as well."""
TOLD = folded_words(_TOLD)
THINGS = folded_words(_THINGS)
FAILS = folded_words(_FAILS)
FREE_TEXT = folded_words(_FREE_TEXT)
NEGATED = tuple(_NEGATED.split())
GOES_ON = tuple(_GOES_ON.split())
NOT = folded_words("not never t nicht nie niemals")
UNSPACED = tuple(
    sorted(
        {word for word in _STRONG.split() if _UNSPACED.fullmatch(word)} - set(_EVERYDAY.split()),
        key=len,
        reverse=True,
    )
)
"""What stops at either end of a word that was written without blanks, the longest first."""
# Words of orders that no finger makes of a stop: ``halb links``.
_NO_SLIPS = "halb"
MISSPELT = frozenset().union(*map(_misspelt, MISSPELT_OF)) - STOPPING - folded_words(_NO_SLIPS)
