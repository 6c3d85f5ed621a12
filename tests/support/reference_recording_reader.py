"""An independent reader of recordings: the packages mcap and mcap-ros2-support.

It reads run.mcap in the current folder and compares every message with rows.jsonl (a line for each tick of the trace),
map.json and paths.json. It prints the number of messages. A different value ends it with an assertion.
"""

import json
import math
import struct
from collections import defaultdict

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

TYPES = {
    "/map": "nav_msgs/msg/OccupancyGrid",
    "/plan": "nav_msgs/msg/Path",
    "/scan": "sensor_msgs/msg/LaserScan",
    "/odom": "nav_msgs/msg/Odometry",
    "/cmd_vel": "geometry_msgs/msg/TwistStamped",
    "/tf": "tf2_msgs/msg/TFMessage",
    "/local_plan/markers": "visualization_msgs/msg/MarkerArray",
    "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
    "/inbye/tick": "inbye_msgs/msg/Tick",
}
MODES = "driving rotating blocked escaping arrived failed parking at_waypoint evading sensor_fault".split()
LINE_LIST, LINE_STRIP, CYLINDER, DELETE_ALL = 5, 4, 3, 3


def same(one, other):
    """Whether two numbers are equal, or both NaN."""
    return one == other or (math.isnan(one) and math.isnan(other))


def rounded(number):
    return struct.unpack("<f", struct.pack("<f", number))[0]


def seconds(stamp):
    return stamp.sec + stamp.nanosec * 1e-9


def yaw_of(turn):
    assert turn.x == 0.0 and turn.y == 0.0
    return 2.0 * math.atan2(turn.z, turn.w)


def turned(angle):
    return math.remainder(angle, 2.0 * math.pi)


def check_tick(tick, row, number):
    assert tick.tick == number
    assert tick.time_s == row["time_s"] and tick.scan_s == row["time_s"]
    assert [tick.x, tick.y, tick.yaw] == row["belief"]
    assert tick.command_linear == row["command"]["linear"]
    assert tick.command_angular == row["command"]["angular"]
    assert [tick.target_x, tick.target_y] == row["local_target"]
    assert MODES[tick.mode] == row["mode"]
    counts = [tick.admissible, tick.collision, tick.cannot_stop, tick.outside]
    assert tick.admissible == row["admissible"] and sum(counts) == row["samples"]
    assert tick.sampled == (row["samples"] > 0)
    assert tick.plans == row["path"] + 1


def check_command(message, tick):
    linear, angular = message.twist.linear, message.twist.angular
    assert [linear.x, linear.y, linear.z] == [tick.command_linear, 0.0, 0.0]
    assert [angular.x, angular.y, angular.z] == [0.0, 0.0, tick.command_angular]
    assert message.header.frame_id == "base_link"


def check_scan(scan, tick):
    assert scan.header.frame_id == "base_link" and tick.lidar_x == tick.lidar_y == 0.0
    assert scan.angle_min == rounded(tick.angle_min)
    assert scan.angle_increment == rounded(tick.angle_increment)
    assert scan.angle_max == rounded(tick.angle_min + (len(tick.ranges) - 1) * tick.angle_increment)
    assert scan.range_max == rounded(tick.range_max) and 0.0 < scan.range_min < scan.range_max
    assert len(scan.ranges) == len(tick.ranges) > 0 and len(scan.intensities) == 0
    assert all(same(one, rounded(other)) for one, other in zip(scan.ranges, tick.ranges))


def check_odometry(odometry, transforms, tick):
    assert odometry.header.frame_id == "odom" and odometry.child_frame_id == "base_link"
    assert odometry.twist.twist.linear.x == tick.linear
    assert odometry.twist.twist.angular.z == tick.angular
    frame, robot = transforms.transforms
    assert (frame.header.frame_id, frame.child_frame_id) == ("map", "odom")
    assert (robot.header.frame_id, robot.child_frame_id) == ("odom", "base_link")
    place, turn = robot.transform.translation, robot.transform.rotation
    pose = odometry.pose.pose
    assert (place.x, place.y, place.z) == (pose.position.x, pose.position.y, pose.position.z)
    assert (turn.z, turn.w) == (pose.orientation.z, pose.orientation.w)
    yaw, origin = yaw_of(frame.transform.rotation), frame.transform.translation
    x = origin.x + math.cos(yaw) * place.x - math.sin(yaw) * place.y
    y = origin.y + math.sin(yaw) * place.x + math.cos(yaw) * place.y
    assert abs(x - tick.x) < 1e-9 and abs(y - tick.y) < 1e-9
    assert abs(turned(yaw + yaw_of(turn) - tick.yaw)) < 1e-9


def check_diagnostics(diagnostics, tick):
    status, protection = diagnostics.status
    assert protection.name == "inbye: protection"
    values = {pair.key: pair.value for pair in status.values}
    assert values["mode"] == MODES[tick.mode]
    for name in ("admissible", "collision", "cannot_stop", "outside", "plans"):
        assert int(values[name]) == getattr(tick, name), name
    assert float(values["latency_ms"]) == tick.took_s * 1e3
    assert status.hardware_id.startswith("CPU") and status.message


def check_markers(array, tick, row):
    first, *shown = array.markers
    assert first.action == DELETE_ALL
    if not tick.sampled:
        assert all((marker.ns, marker.type) == ("moving", CYLINDER) for marker in shown)
        return 0
    fan = shown.pop(0)
    assert (fan.ns, fan.type, fan.header.frame_id) == ("arcs", LINE_LIST, "map")
    assert len(fan.points) == len(fan.colors) > 0 and len(fan.points) % 2 == 0
    starts = [(point.x, point.y) for point in fan.points[::2]]
    begin = starts[0]
    # Each arc has ten segments, which all start at the same point if the arc is a standstill.
    assert len(starts) % 10 == 0 and 0 < len(starts) // 10 <= 5 * 13
    # The arcs start where the robot will be when the command takes effect.
    assert math.hypot(begin[0] - tick.x, begin[1] - tick.y) < 0.5
    admissible = sum(color.r == 0.0 and abs(color.g + color.b - 1.0) < 1e-6 for color in fan.colors)
    assert (admissible > 0) <= (tick.admissible > 0)
    if shown and shown[0].ns == "chosen":
        chosen = shown.pop(0)
        assert chosen.type == LINE_STRIP
        assert (chosen.points[0].x, chosen.points[0].y) == begin
        assert tick.admissible > 0
    else:
        assert tick.admissible == 0
    assert len({marker.id for marker in shown}) == len(shown) and len(shown) % 4 == 0
    for index, marker in enumerate(shown):
        assert marker.ns == ("predicted" if index % 4 else "moving") and marker.type == CYLINDER
        assert marker.scale.x == marker.scale.y > 0.0
    return len(shown)


def check_map(message):
    with open("map.json", encoding="utf-8") as file:
        grid = json.load(file)
    info = message.info
    assert (info.width, info.height) == (grid["width"], grid["height"])
    assert info.resolution == rounded(grid["resolution_m"])
    assert [info.origin.position.x, info.origin.position.y] == grid["origin"][:2]
    assert abs(yaw_of(info.origin.orientation) - grid["origin"][2]) < 1e-12
    assert list(message.data) == grid["cells"]


def check_plans(plans, rows):
    with open("paths.json", encoding="utf-8") as file:
        paths = json.load(file)
    numbers = [row["path"] for row in rows]
    fresh = [tick for tick, number in enumerate(numbers) if tick == 0 or number > numbers[tick - 1]]
    assert len(plans) == len(fresh)
    for (time, plan), tick in zip(plans, fresh):
        assert time == round(rows[tick]["time_s"] * 1e9)
        points = [[stamped.pose.position.x, stamped.pose.position.y] for stamped in plan.poses]
        assert points == paths[numbers[tick]]


def main():
    with open("rows.jsonl", encoding="utf-8") as file:
        rows = [json.loads(line) for line in file]
    by_topic = defaultdict(list)
    with open("run.mcap", "rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        summary = reader.get_summary()
        assert reader.get_header().profile == "ros2"
        for schema, channel, message, decoded in reader.iter_decoded_messages():
            assert schema.name == TYPES[channel.topic] and schema.encoding == "ros2msg"
            assert "offered_qos_profiles" in channel.metadata
            assert message.sequence == len(by_topic[channel.topic])
            by_topic[channel.topic].append((message.log_time, decoded))
        attachments = {attachment.name for attachment in reader.iter_attachments()}
        assert attachments == {"config.toml", "drive.toml"}
        (end,) = reader.iter_metadata()
        assert end.name == "inbye.summary" and int(end.metadata["ticks"]) == len(rows)
    assert set(by_topic) == set(TYPES)
    counted = sum(len(messages) for messages in by_topic.values())
    assert counted == summary.statistics.message_count

    ((_, grid),) = by_topic.pop("/map")
    check_map(grid)
    check_plans(by_topic.pop("/plan"), rows)
    discs = 0
    for number, row in enumerate(rows):
        at = {}
        for topic, messages in by_topic.items():
            time, at[topic] = messages[number]
            assert time == round(row["time_s"] * 1e9), topic
            header = getattr(at[topic], "header", None)
            stamp = header.stamp if header else getattr(at[topic], "stamp", None)
            assert stamp is None or abs(seconds(stamp) - row["time_s"]) < 1e-9
        tick = at["/inbye/tick"]
        check_tick(tick, row, number)
        check_command(at["/cmd_vel"], tick)
        check_scan(at["/scan"], tick)
        check_odometry(at["/odom"], at["/tf"], tick)
        check_diagnostics(at["/diagnostics"], tick)
        discs += check_markers(at["/local_plan/markers"], tick, row)
    assert all(len(messages) == len(rows) for messages in by_topic.values())
    # At least one moving obstacle is shown.
    assert discs > 0
    print(counted)


main()
