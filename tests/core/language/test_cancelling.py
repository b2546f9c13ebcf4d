# ruff: noqa: RUF001 - people type what is ambiguous
"""What ends what somebody has under way, and what speaks of something else."""

from __future__ import annotations

import pytest

from rosic.core.language import Vocabulary, hears_cancel, hears_stop
from rosic.core.language.cancel_detection import is_cancel_word, is_urgent
from tests.core.language.test_stopping import LANGUAGES as STOPPED_IN

LANGUAGES = {
    "German": "abbrechen Abbruch! brich",
    "French": "annuler annulez abandonner",
    "Spanish": "cancelar cancela abortar",
    "Portuguese": "cancelar cancele abortar",
    "Italian": "annulla annullare interrompi",
    "Dutch": "annuleren annuleer afbreken",
    "Swedish": "avbryt avbryta",
    "Finnish": "peruuta keskeytä",
    "Polish": "anuluj przerwij",
    "Czech": "zruš zrušit přeruš",
    "Croatian": "otkaži prekini",
    "Serbian": "откажи прекини otkaži",
    "Russian": "отмена отмени ОТМЕНИТЬ прервать",
    "Ukrainian": "скасувати скасуй",
    "Bulgarian": "отмени прекрати",
    "Turkish": "iptal vazgeç",
    "Greek": "ακύρωση ΑΚΎΡΩΣΗ",
    "Hungarian": "mégse megszakít",
    "Romanian": "anulează anuleaza",
    "Arabic": "إلغاء الغاء ألغ",
    "Persian": "لغو",
    "Urdu": "منسوخ",
    "Hebrew": "בטל ביטול",
    "Hindi": "रद्द",
    "Bengali": "বাতিল",
    "Tamil": "ரத்து",
    "Telugu": "రద్దు",
    "Chinese": "取消 中断 撤销",
    "Japanese": "キャンセル 取り消し ｷｬﾝｾﾙ 中止",
    "Korean": "취소 취소해",
    "Vietnamese": "hủy huỷ",
    "Thai": "ยกเลิก",
    "Indonesian": "batal batalkan",
    "Swahili": "ghairi",
}
EVERYTHING = """
cancel Cancel CANCEL!! cancel. /cancel /cancel@lab_robots_bot abort ABORT! cancle cancell
"""
KINDLY = [
    "please cancel",
    "cancel please",
    "cancel it",
    "cancel that now",
    "cancel everything",
    "cancel all my orders",
    "ok, cancel that",
    "brich ab",
    "iptal et",
    "रद्द करो",
    "hủy bỏ",
    "abort mission",
    "cancel my task",
    "cancel the mission",
    "status\ncancel",
    "ＣＡＮＣＥＬ",
    "c\u200bancel",
    "cancel cancel cancel " * 5,
]
OTHER = [
    "cancel booking",
    "cancel my bookings",
    "/cancel booking 0a1b2c3d4e5f",
    "/cancel 0a1b2c3d4e5f",
    "/cancel only 0a1b2c3d4e5f",
    "cancel kuka1 tomorrow 14:30",
    "cancel task 7",
    "cancel mission restock",
    "don't cancel",
    "not cancelled yet",
    "the flight was late, so we had to cancel our whole trip to the sea",
    "channel",
    "about",
    "cancer",
    "omni move 1 m",
    "",
    "  ",
    "cancel " + "x" * 300,
]


def test_every_language_that_can_stop_can_cancel() -> None:
    assert set(LANGUAGES) == set(STOPPED_IN)


@pytest.mark.parametrize("language", LANGUAGES)
def test_it_is_understood_in_many_languages(language: str, vocabulary: Vocabulary) -> None:
    for word in LANGUAGES[language].split():
        assert hears_cancel(word, vocabulary.known) == (), word
        assert hears_stop(word, vocabulary.known) is None, "it is no stop of everybody's robots"
        assert is_urgent(word)


@pytest.mark.parametrize("text", [*EVERYTHING.split(), *KINDLY])
def test_it_ends_everything_of_ones_own(text: str, vocabulary: Vocabulary) -> None:
    assert hears_cancel(text, vocabulary.known) == ()


@pytest.mark.parametrize("text", OTHER)
def test_what_is_something_else_ends_nothing(text: str, vocabulary: Vocabulary) -> None:
    assert hears_cancel(text, vocabulary.known) is None


def test_names_are_returned_and_a_word_that_means_nobody_as_well(vocabulary: Vocabulary) -> None:
    assert hears_cancel("cancel omni", vocabulary.known) == ("omni",)
    assert hears_cancel("omni, cancel!", vocabulary.known) == ("omni",)
    assert hears_cancel("cancel omni and kuka1", vocabulary.known) == ("omni", "kuka1")
    assert hears_cancel("cancel omin", vocabulary.known) == ("omin",)
    assert hears_cancel("取消omni", vocabulary.known) == ("omni",)


def test_a_stop_beside_it_is_a_stop(vocabulary: Vocabulary) -> None:
    assert hears_stop("cancel\nstop", vocabulary.known) == ()


def test_nothing_may_be_called_so() -> None:
    assert is_cancel_word("Annuler")
    assert not is_cancel_word("cancel goal")
