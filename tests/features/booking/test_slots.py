"""`/slots`: mine, a robot's day, the calendar file."""

from __future__ import annotations

from tests.features.booking.booking_handlers import ANN, BEN, VI, Lab


async def test_my_times() -> None:
    async with Lab().open() as lab:
        assert await lab.say(ANN, "/slots") == "You have no times booked."
        assert lab.labels() == []
        await lab.book(ANN, "kuka1 now 1h")
        await lab.book(ANN, "arm tomorrow 9-10")
        await lab.book(ANN, "arm 24 Nov 23:00 2h")
        await lab.say(BEN, "/book omni 10:00 1h")
        await lab.say(ANN, "/wait omni")
        assert await lab.say(ANN, "/slots") == (
            "Your times (Europe/Vienna):\n"
            "KUKA iiwa: now, until 11:00\n"
            "The Arm: tomorrow 09:00 to 10:00\n"
            "The Arm: Tue 24 Nov 23:00 to Wed 25 Nov 01:00\n"
            "You are number 1 in the queue for omni."
        )
        assert lab.labels() == ["Cancel one"]


async def test_a_long_list_is_cut_and_says_so() -> None:
    async with Lab().open() as lab:
        await lab.book(ANN, "kuka1 every day 14:00 1h 25 times")
        lines = (await lab.say(ANN, "/slots")).splitlines()
        assert (len(lines), lines[-1]) == (22, "and 5 more")


async def test_a_robots_day() -> None:
    async with Lab().open() as lab:
        await lab.book(ANN, "kuka1 now 1h")
        await lab.book(BEN, "kuka1 14:00 1h")
        await lab.book(BEN, "kuka1 23:00 2h")
        assert await lab.say(BEN, "/slots kuka1") == (
            "KUKA iiwa on Sat 21 Nov 2026 (Europe/Vienna):\n"
            "10:00 to 11:00 Ann\n14:00 to 15:00 you\n23:00 to 24:00 you\nOtherwise it is free."
        )
        assert lab.labels() == ["Book 11:00 for 1 h", "Next day"]
        assert await lab.tap(BEN, "Next day") == (
            "KUKA iiwa on Sun 22 Nov 2026 (Europe/Vienna):\n00:00 to 01:00 you\n"
            "Otherwise it is free."
        )
        assert await lab.say(BEN, "/slots kuka1 mon") == (
            "KUKA iiwa is free all day on Mon 23 Nov 2026 (Europe/Vienna)."
        )
        await lab.say(BEN, "/slots kuka1")
        assert await lab.tap(BEN, "Book 11:00 for 1 h") == (
            "KUKA iiwa is yours on Sat 21 Nov 2026 from 11:00 to 12:00 (Europe/Vienna)."
        )


async def test_who_may_not_move_it_is_offered_no_time() -> None:
    async with Lab().open() as lab:
        await lab.say(VI, "/slots kuka1 tomorrow")
        assert lab.labels() == ["Next day"]


async def test_names_are_shown_only_of_robots_one_may_see() -> None:
    async with Lab().open() as lab:
        lab.hidden.add("arm")
        await lab.book(ANN, "arm 14:00 1h")
        assert await lab.say(BEN, "/slots arm") == (
            'I know no robot "arm". Say robots for those you may use.'
        )
        assert "Ann" not in await lab.say(BEN, "/slots The Arm")


async def test_odd_days() -> None:
    async with Lab().open() as lab:
        assert await lab.say(BEN, "/slots kuka1 9-10") == (
            "Which day? Say it as tomorrow, mon or 2027-02-01."
        )
        assert lab.offers() == ("slots kuka1 tomorrow",)
        assert (await lab.say(BEN, "/slots kuka1 2199-12-31")).startswith("Which day?")
        assert (await lab.say(BEN, "/slots kuka1 1970-01-01")).startswith("KUKA iiwa is free")
        assert await lab.say(BEN, "/slots cf1") == (
            "cf1 needs no booking: whoever comes first has it."
        )
        lab.selected[BEN] = "kuka1"
        assert (await lab.say(BEN, "/slots tomorrow.")).startswith("KUKA iiwa is free all day")


async def test_the_calendar_file() -> None:
    async with Lab().open() as lab:
        slot = await lab.book(ANN, "kuka1 tomorrow 14:00 1h")
        await lab.book(BEN, "kuka1 tomorrow 15:00 1h")
        assert (await lab.say(ANN, "/slots ics")).startswith("Your times, for the calendar")
        assert lab.reply is not None
        file = lab.reply.attachment
        assert file is not None
        assert (file.name, file.media_type) == ("my-times.ics", "text/calendar")
        said = file.content.decode()
        assert said.startswith("BEGIN:VCALENDAR\r\n")
        assert said.endswith("END:VCALENDAR\r\n")
        assert said.count("BEGIN:VEVENT") == 1
        assert f"UID:{slot.id}@rosic\r\n" in said
        assert "DTSTART:20261122T130000Z\r\nDTEND:20261122T140000Z\r\nSUMMARY:KUKA iiwa" in said
        assert "X-WR-CALNAME:Ann\r\n" in said
        lab.chat.file_bytes = 0
        assert await lab.say(ANN, "/slots ics") == said  # to be copied, where no file can be sent
