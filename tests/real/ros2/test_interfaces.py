from __future__ import annotations

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from rosic.errors import ConfigurationError
from rosic.robots.ros2.client.runtime import RosRuntime
from rosic.robots.ros2.interfaces import cache as keeping
from rosic.robots.ros2.interfaces.__main__ import main
from rosic.robots.ros2.interfaces.build import InterfacePackage
from rosic.robots.ros2.interfaces.cache import OWN, default_cache, ensure_built, make_importable
from rosic.robots.ros2.messages.encode import slots, to_message
from rosic.robots.ros2.messages.types import TypeRegistry
from tests.pace import pace

GRIPPER = "control_msgs/action/GripperCommand"
ACTIONS = {
    "Follow": {"leader": "string", "distance_m": "double", "bearing_rad": "double"},
    "Formation": {"shape": "string", "spacing_m": "double"},
    "GoTo": dict.fromkeys(("x_m", "y_m", "z_m", "yaw_rad", "speed_m_s"), "double"),
    "Grasp": {"force_n": "double"},
    "Move": {"direction": "string", "distance_m": "double", "speed_m_s": "double"},
    "MoveJoint": {"joint": "int32", "angle_rad": "double"},
    "Perform": {},
    "SetPose": {"name": "string"},
    "TakeOff": {"height_m": "double"},
    "Turn": {"direction": "string", "angle_rad": "double", "speed_rad_s": "double"},
}


@pytest.mark.usefixtures("interfaces")
@pytest.mark.parametrize("name", sorted(ACTIONS))
def test_our_actions_say_what_the_profiles_rely_on(name: str) -> None:
    action = TypeRegistry([f"rosic_interfaces/action/{name}"]).action(
        f"rosic_interfaces/action/{name}"
    )
    start = {"start_at": "builtin_interfaces/Time"}
    assert action.Goal.get_fields_and_field_types() == ACTIONS[name] | start
    assert action.Result.get_fields_and_field_types() == {
        "success": "boolean",
        "message": "string",
        "fact_names": "sequence<string>",
        "fact_values": "sequence<double>",
    }
    assert action.Feedback.get_fields_and_field_types() == {"fraction": "float", "stage": "string"}


@pytest.mark.usefixtures("interfaces")
def test_a_member_of_a_swarm_says_where_it_is() -> None:
    cls = TypeRegistry(["rosic_interfaces/msg/SwarmState"]).message(
        "rosic_interfaces/msg/SwarmState"
    )
    assert set(slots(cls)) == {
        "id",
        "pose",
        "velocity",
        "flying",
        "busy",
        "landing",
        "leader",
        "goal",
        "stamp",
    }
    values = {"id": "cf1", "velocity.linear.x": 0.5, "flying": True, "stamp.sec": 5}
    assert to_message(cls, values).velocity.linear.x == 0.5


def test_the_package_is_an_ordinary_one_for_colcon() -> None:
    described = (OWN.source / "CMakeLists.txt").read_text()
    for file in OWN.files():
        assert f'"{file.parent.name}/{file.name}"' in described
    manifest = (OWN.source / "package.xml").read_text()
    for used in ("action_msgs", "builtin_interfaces", "geometry_msgs"):
        assert f"<depend>{used}</depend>" in manifest


def gripper(folder: Path) -> InterfacePackage:
    """A package of somebody else, as a robot's maker would ship it."""
    (folder / "action").mkdir(parents=True)
    (folder / "msg").mkdir()
    (folder / "msg" / "GripperCommand.msg").write_text("float64 position\nfloat64 max_effort\n")
    (folder / "action" / "GripperCommand.action").write_text(
        "GripperCommand command\n---\nfloat64 position\nbool reached_goal\n---\nfloat64 position\n"
    )
    return InterfacePackage("control_msgs", folder)


@pytest.mark.limit(240)
@pytest.mark.usefixtures("graph")
async def test_a_foreign_package_is_built_once_for_all_who_ask(tmp_path: Path) -> None:
    package, cache = gripper(tmp_path / "source"), tmp_path / "cache"
    told: list[tuple[str, float]] = []
    with ThreadPoolExecutor(3) as pool:
        asked = [
            pool.submit(ensure_built, package, cache, lambda *step: told.append(step))
            for _ in range(3)
        ]
        built = {future.result() for future in asked}
    assert len(built) == 1
    assert {name for name, _ in told} == {"control_msgs"}
    fractions = [fraction for _, fraction in told]
    assert len(fractions) > 10
    assert 0 < min(fractions) < 0.1
    assert max(fractions) == fractions[-1] == 1.0
    assert fractions.count(1.0) == 1, "only who built it said so"
    assert [path.name for path in cache.iterdir() if path.is_dir()] == [built.pop().name]
    stamp = next(cache.glob("control_msgs-*")).stat().st_mtime_ns
    assert (
        main(["--output", str(cache), "--package", "control_msgs", "--source", str(package.source)])
        == 0
    )
    assert next(cache.glob("control_msgs-*")).stat().st_mtime_ns == stamp

    make_importable(package, cache)
    try:
        types = TypeRegistry([GRIPPER])
        goal = to_message(types.action(GRIPPER).Goal, {"command.max_effort": 15})
        assert goal.command.max_effort == 15.0
        async with await RosRuntime.open(types) as runtime:
            link = await runtime.action("/kuka1/grasp", GRIPPER)
            assert not link.ready()
    finally:
        sys.path[:] = [entry for entry in sys.path if not entry.startswith(str(cache))]
        for module in [name for name in sys.modules if name.split(".")[0] == "control_msgs"]:
            del sys.modules[module]  # others mean the whole package by it

    (package.source / "msg" / "GripperCommand.msg").write_text("float64 max_effort\n")
    assert keeping._digest(package) not in str(next(cache.glob("control_msgs-*")))


def test_a_file_that_makes_no_sense_is_named(tmp_path: Path) -> None:
    (tmp_path / "msg").mkdir()
    (tmp_path / "msg" / "Broken.msg").write_text("float65 x\n")
    with pytest.raises(ConfigurationError, match=r"could not be generated: .*float65"):
        ensure_built(InterfacePackage("broken_msgs", tmp_path), tmp_path / "cache")
    assert not list((tmp_path / "cache").glob("broken_msgs-*"))
    assert not list((tmp_path / "cache").glob(".broken_msgs-*"))


def test_a_folder_without_interfaces_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["--output", str(tmp_path), "--package", "none", "--source", str(tmp_path)]) == 2
    assert "There is no .msg, .srv or .action file" in capsys.readouterr().err


def test_a_cache_that_cannot_be_written_says_so(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(ConfigurationError, match="cannot be kept in"):
        ensure_built(OWN, tmp_path / "file" / "cache")


def test_the_cache_goes_with_the_environment() -> None:
    assert default_cache().is_relative_to(sys.prefix)


def test_the_command_explains_itself() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "rosic.robots.ros2.interfaces", "--help"],
        env={"PATH": "/usr/bin:/bin", "PYTHONPATH": str(Path(__file__).parents[3] / "src")},
        capture_output=True,
        text=True,
        timeout=120 * pace(),
        check=True,
    )
    assert "--output" in done.stdout
