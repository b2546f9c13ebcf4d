"""What is known of stopped robots."""

from __future__ import annotations

from rosic.core.stop_registry import StopRegistry, not_known_yet


def make_stops() -> StopRegistry:
    return StopRegistry(["omni", "kuka1", "cf1"], {"kuka1": (4, True)}, not_known_yet())


def test_it_begins_with_what_was_found_and_nobody_stopped_in_this_run() -> None:
    stops = make_stops()
    assert stops.latched() == ("kuka1",)
    assert (stops["kuka1"].generation, stops["omni"].generation) == (4, 0)
    assert {entry.at_ns for entry in stops.values()} == {0}
    assert stops.newest() == (4, "")
    assert StopRegistry([], {}, not_known_yet()).newest() == (0, "")
    assert stops.barred("omni") is not None, "until it is known what may be resumed, nothing is"
    stops.barred.bind(lambda _robot: None)
    assert stops.barred("omni") is None


def test_of_a_stop_that_was_found_nobody_is_known_and_a_later_one_does_not_hide_it() -> None:
    stops = make_stops()
    assert (stops["kuka1"].stoppers, stops["omni"].stoppers) == ({"": 0}, {})
    stops.stop("kuka1", "ada", 20)
    stops.stop("omni", "ada", 20)
    assert not stops["kuka1"].alone("ada"), "somebody else had stopped it before"
    assert stops["omni"].alone("ada")


def test_the_newest_stop_is_the_last_and_every_stop_counts() -> None:
    stops = make_stops()
    assert stops.stop("omni", "ada", 20) == 1
    assert stops.newest() == (5, "ada")
    assert stops.stop("cf1", "bo", 10) == 1
    assert stops.newest() == (6, "ada"), "Bo's was earlier"
    assert stops.stop("omni", "vi", 30) == 2
    assert stops.newest() == (7, "vi")
    assert stops.latched() == ("omni", "kuka1", "cf1")
    assert (stops["omni"].by, stops["omni"].since_ns, stops["omni"].at_ns) == ("vi", 30, 30)


def test_only_a_resume_of_the_last_stop_undoes_it() -> None:
    stops = make_stops()
    for generation in (3, 5):
        stops.resume("kuka1", generation)
        assert stops["kuka1"].latched
    stops.resume("kuka1", 4)
    assert stops.latched() == ()
    assert stops["kuka1"].generation == 4


def test_no_stop_lies_ahead_of_a_clock_that_was_set_back() -> None:
    stops = make_stops()
    stops.stop("omni", "ada", 20)
    stops.stop("cf1", "ada", 5)
    stops.not_later(10)
    assert (stops["omni"].at_ns, stops["omni"].since_ns, stops["cf1"].at_ns) == (10, 20, 5)


def test_what_somebody_ended_is_counted_for_them_and_for_the_robots_they_named() -> None:
    stops = make_stops()
    stops.cancel("bo", iter(["omni", "cf1"]))
    stops.cancel("bo", ["omni"])
    assert [stops.cancelled("bo", robot) for robot in ("omni", "cf1", "kuka1")] == [2, 1, 0]
    stops.cancel("bo", [])
    assert [stops.cancelled("bo", robot) for robot in ("omni", "cf1", "kuka1")] == [3, 2, 1]
    assert stops.cancelled("ada", "omni") == 0
    assert stops.latched() == ("kuka1",), "it stops nothing"


def test_everybody_who_stopped_it_since_it_was_free_is_remembered() -> None:
    stops = make_stops()
    assert not stops["kuka1"].alone("ada"), "it was found so: nobody knows who stopped it"
    stops.stop("omni", "bo", 10)
    assert stops["omni"].alone("bo")
    stops.stop("omni", "ada", 20)
    stops.stop("omni", "bo", 30)
    assert stops["omni"].stoppers == {"bo": 10, "ada": 20}
    assert not stops["omni"].alone("ada")
    stops.resume("omni", 3)
    stops.stop("omni", "ada", 40)
    assert stops["omni"].alone("ada")
    stops.stop("omni", "", 50)
    assert not stops["omni"].alone("ada"), "somebody of whom nothing is known"
