"""More profiles that are each wrong in one place."""

from __future__ import annotations

from tests.config.profile_error_cases import AT_REST, LINE, STOP, Case
from tests.config.profile_text import DIALOGUE

MORE_CASES = [
    Case(
        "word of two skills",
        "  light:\n    class: task\n",
        "  light:\n    class: task\n    words: [shift] #!\n",
        'Robot rover: "shift" means both move and light.',
        "Choose another word.",
    ),
    Case(
        "skill called like a command",
        "  light:\n",
        "  status: #!\n",
        "Robot rover: skill 'status' cannot be called \"status\"",
    ),
    Case(
        "robot called stop",
        "words: [buggy]",
        "words: [halt] #!",
        'Robot rover cannot be called "halt"',
    ),
    Case(
        "word of two choices",
        "          back: [backwards]",
        "          back: [ahead]",
        "Robot rover, skill 'move': parameter 'direction': \"ahead\" is both ",
    ),
    # ---- ROS ----
    Case(
        "name",
        "name: /rover/move",
        "name: rover/move #!",
        "'rover/move' is not a ROS name.",
        "Write it from the root, for example /omni/odom.",
    ),
    Case(
        "node", "node: /rover/driver", "node: /rover/1driver", "'/rover/1driver' is not a ROS name."
    ),
    Case(
        "old spelling of a type",
        "type: std_srvs/srv/SetBool",
        "type: std_srvs/SetBool #!",
        "'std_srvs/SetBool' is not a ROS service type.",
        "Write package/srv/Type, for example std_srvs/srv/Trigger.",
    ),
    Case(
        "a number for yes or no",
        "on: { value: true }, off: { value: false }",
        "on: { value: 1 }, off: { value: 0 }",
        "'data' of std_srvs/srv/SetBool is true or false, and '$state.value' is neither.",
        "Write true or false, or $state.value with means: { on: { value: true } } and so on.",
    ),
    Case(
        "a stop that releases",
        "stop: { service: /rover/stop, type: std_srvs/srv/Trigger",
        "stop: { service: /rover/stop, type: std_srvs/srv/SetBool",
        "A stop by std_srvs/srv/SetBool has to say data: by itself it is false, which releases a "
        "brake.",
        "Write request: { data: true }, or false where that is what stops this robot.",
    ),
    Case(
        "a release that stops again",
        "stop: { service: /rover/stop, type: std_srvs/srv/Trigger",
        "stop: { service: /rover/stop, type: std_srvs/srv/SetBool, request: { data: true }, "
        "release: { data: true }",
        "'release' says what request says: that would stop it again",
    ),
    Case(
        "a release of something else",
        "stop: { service: /rover/stop, type: std_srvs/srv/Trigger",
        "stop: { service: /rover/stop, type: std_srvs/srv/SetBool, request: { data: true }, "
        "release: { free: true }",
        "'release' has to say every field that request says",
    ),
    Case(
        "a code that is no number",
        "      request: { data: $state.value }\n",
        "      request: { data: $state.value }\n      success: code\n      good: 0\n"
        "      codes: { three: blocked } #!\n",
        "'three' is not a code.",
        "Write a number: 3.",
    ),
    Case(
        "numbers and words of one meaning",
        "off: { value: false }",
        "off: { value: slow }",
        "Means must give the same kind of 'value' for every choice.",
    ),
    Case(
        "two types of one service",
        LINE,
        f"{LINE}files: {{ accept: [yaml], inbox: /srv/in, deliver: {{ service: {{ name: "
        "/rover/light, type: std_srvs/srv/Trigger, request: { data: $path } } } } #!\n",
        "The service /rover/light has the type std_srvs/srv/SetBool elsewhere in this profile",
        "Ask the robot which: ros2 service type /rover/light.",
    ),
    Case(
        "kind of a type",
        "type: rosic_interfaces/action/Move",
        "type: rosic_interfaces/msg/Move #!",
        "'rosic_interfaces/msg/Move' is not a ROS action type.",
        "Write package/action/Type, for example rosic_interfaces/action/Move.",
    ),
    Case(
        "message type",
        "type: geometry_msgs/msg/Twist",
        "type: geometry_msgs/srv/Twist #!",
        "'geometry_msgs/srv/Twist' is not a ROS message type.",
    ),
    Case(
        "field",
        "message: { linear.x: $speed }",
        "message: { linear..x: $speed } #!",
        "'linear..x' is not a field of a message.",
        "Join fields by dots, as in twist.twist.linear.x.",
    ),
    Case(
        "fields at rest",
        '"twist.twist.linear.x, twist.twist.angular.z"',
        "twist twist #!",
        "'twist twist' is not a field of a message.",
    ),
    Case(
        "placeholder",
        "distance_m: $distance",
        "distance_m: $distnce",
        "$distnce is not a parameter of this skill.",
        "Did you mean distance?",
    ),
    Case(
        "unused parameter",
        "goal: { direction: $direction, distance_m: $distance, steps: $steps }",
        "goal: { direction: $direction, distance_m: $distance }",
        "'steps' is asked of people but never sent to the robot.",
        "Write $steps where it belongs under action.goal.",
    ),
    Case(
        "two bindings",
        "    set_parameters: {",
        "    service: { name: /a, type: a/srv/B }\n    set_parameters: {",
        "A skill has at most one of topic, service, action, set_parameters.",
    ),
    Case(
        "no binding",
        "    set_parameters: { node: /rover/driver, values: { gain: $gain } }\n",
        "",
        "'tune' says nothing of how ROS carries it out.",
        "Give one of topic, service, action, set_parameters.",
    ),
    Case(
        "no namespace",
        "namespace: /rover }",
        'namespace: "" } #!',
        "A ros2 robot needs a namespace.",
        "For example /rover; / for one that has none.",
    ),
    # ---- moving safely ----
    Case(
        "no watchdog",
        "watchdog_s: 0.5\n",
        "",
        "Skill 'drive' streams a velocity, but the profile states no watchdog_s",
    ),
    Case(
        "slow stream",
        "stream_hz: 10",
        "stream_hz: 2 #!",
        "2 Hz is too slow for a robot that stops by itself after 0.5 s.",
        "Send at 4 Hz or more.",
    ),
    Case(
        "a velocity once",
        "      stream_hz: 10\n",
        "",
        "A single velocity would keep the robot moving.",
        "Give stream_hz, so that it is sent for a time and ends in zero.",
    ),
    Case(
        "stream without an end",
        "      duration: { unit: s, min: 0.1, max: 5 }\n",
        "",
        "A stream needs a parameter 'duration' in s that is above 0.",
    ),
    Case(
        "stream of no time",
        "duration: { unit: s, min: 0.1",
        "duration: { unit: s, min: 0",
        "A stream needs a parameter 'duration' in s that is above 0.",
    ),
    Case(
        "nothing to stop it",
        STOP + "\n",
        "",
        "'stop' is missing: nothing would stop this robot.",
        "Give stop a service, a velocity topic to zero, or both.",
    ),
    Case(
        "stop that stops nothing",
        STOP,
        "stop: { type: std_srvs/srv/Trigger } #!",
        "'stop' names neither a service nor a velocity topic to zero.",
    ),
    Case(
        "rest never measured",
        AT_REST + "\n",
        "",
        "'at_rest' is missing: a stop of this robot could never be confirmed.",
        "Name a topic and the fields that are near zero when it stands still.",
    ),
    Case(
        "nothing left that shows rest",
        AT_REST,
        f"{AT_REST}\n  stop_only: no.such #!",
        "What stop_only names has to be some of the fields, and not all.",
    ),
    # ---- the text link ----
    Case(
        "text outside a dialogue",
        "      gain: { min: 0, max: 1, default: 0.5 }",
        "      gain: { text: true } #!",
        "Free text goes to a robot only over its dialogue.",
        "Set link.dialogue to true, or give choices instead of text.",
    ),
    Case(
        "text into a service",
        "say: { class: task, parameters: { text: { text: true } } }",
        "say: { class: task, parameters: { text: { text: true } }, #!\n"
        "    service: { name: /a, type: a/srv/B, request: { data: $text } } }",
        "Free text never goes into a topic, service or action.",
        base=DIALOGUE,
    ),
    Case(
        "full of what is no share",
        '    unit: "%"\n',
        "    unit: V\n    full: 100 #!\n",
        "'full' is of a share: it needs the unit %.",
    ),
    Case(
        "half a reported value",
        "    field: percentage\n",
        "",
        "A reported value needs topic, type and field, or none of them.",
    ),
]
