"""Does somebody want to hold up what is under way, in a word that neither stops nor cancels?

``Wait``, ``no``, ``oops``: words of every day, which stop nothing. They are looked for only where
nothing else could be made of a line, so that whoever wrote one is shown the buttons that do.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.language.stop_detection import words_of
from rosic.core.language.stop_words import ALONG, EVERYTHING, fold_stop, folded_words, shorten

if TYPE_CHECKING:
    from collections.abc import Container

_WAIT = """
    wait no nope nah nono oops ups whoa wow careful slowly hold hang easy enough wrong
    warte wartet warten moment nein nee nö vorsicht langsam hoppla falsch genug achtung
    attends attendez attendre non attention doucement minute
    espera espere esperen esperad cuidado momento despacio
    aspetta aspettate aspetti attento attenzione piano no
    espere espera esperem não calma devagar
    wacht nee vänta nej vent vente nei odota odottakaa ei
    počkej počkejte ne počkaj počkajte nie czekaj czekajcie poczekaj poczekajcie
    čekaj čekajte pričekaj pričekajte sačekaj sačekajte počakaj počakajte
    подожди подождите погоди погодите нет зачекай зачекайте почекай почекайте чекай чекайте ні
    изчакай изчакайте чакай чакайте чекај чекајте не
    bekle bekleyin hay\u0131r yavaş περίμενε περιμένετε όχι várj várjon várjatok nem
    așteaptă așteptați nu انتظر انتظري انتظروا لا مهلا صبر صبرکن نه نہیں ٹھہرو
    חכה חכי חכו רגע לא ठहरो ठहरिए नहीं অপেক্ষা না দাঁড়াও காத்திரு இல்லை வேண்டாம் వద్దు లేదు
    等等 等一下 等一等 等 等会 等會 慢着 慢著 不 不要 不对 不對 不是 不行 小心
    待って まって 待て 待ってください ちょっと待って ちょっと いいえ いや だめ ダメ 駄目 違う
    기다려 기다려줘 기다려요 기다리세요 잠깐 잠깐만 잠깐만요 잠시만요 아니 아니요 아니야 안돼 안돼요
    đợi chờ không รอ รอก่อน รอเดี๋ยว เดี๋ยว ไม่ ไม่ใช่ tunggu tidak jangan subiri hapana
    hintay maghintay teka hindi palauk palaukite pagaidi uzgaidi nē oota ei prit jo
    gözlə gözləyin yox күте күт жоқ хүлээ үгүй սպասիր սպասեք ոչ დაელოდე მოიცადე არა
    नको ਉਡੀਕ ਨਹੀਂ રાહ ના ಕಾಯಿರಿ ಬೇಡ കാത്തിരിക്കൂ വേണ്ട စောင့် မဟုတ်ဘူး ចាំ ទេ ລໍຖ້າ ບໍ່ ጠብቅ አይ
"""

# Goes along with one of them: ``warte mal``, ``hold on``, ``not that``, ``attendez un peu``.
_WITH = """
    on up a an one sec second seconds moment minute not so fast that this way there too far much
    mal kurz eben doch bitte ein einen augenblick nicht so schnell das da dort zu weit viel
    un une instant peu pas un momento un attimo even lite litt lidt hetki chwilę chwile chvíli
    минуту минутку секунду bir dakika saniye kicsit puțin sebentar dulu 一下 吧 请 請
"""


WAIT = folded_words(_WAIT)
WITH = folded_words(_WITH) | ALONG | EVERYTHING
# A longer line talks of something.
LONGEST = 64


def hears_wait(text: str, known: Container[str] = (), *, whole: bool = False) -> bool:
    """Whether a text begins with a word that wants something held up.

    Args:
        text: As it was typed; nothing else could be made of it.
        known: Names of robots, groups, skills, verbs and choices in small letters.
        whole: Nothing else may stand in it: in a chat of many, people talk to each other.
    """
    line = text.strip()
    if len(line) > LONGEST or "\n" in line or line.startswith("/"):
        return False
    words = words_of(line, known)
    folded = [fold_stop(word) for word in words]
    waits = [word in WAIT or shorten(word) in WAIT for word in folded]
    along = [f in WITH or w in known for w, f in zip(words, folded, strict=True)]
    if whole:
        return any(waits) and all(w or a for w, a in zip(waits, along, strict=True))
    leading = (w for w, a in zip(waits, along, strict=True) if w or not a)
    return next(leading, False)
