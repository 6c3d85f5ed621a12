"""A simulated robot as an independent peer: Eclipse Cyclone DDS. Runs the program and prints facts.

    python peer.py PROGRAM SCENARIO

Start it in a network namespace with only the loopback: no packet reaches another machine.
"""

import json
import math
import os
import random
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import urllib.request

os.environ["CYCLONEDDS_URI"] = (
    "<CycloneDDS><Domain><General>"
    "<Interfaces><NetworkInterface name='lo' multicast='true'/></Interfaces>"
    "<AllowMulticast>true</AllowMulticast>"
    "</General></Domain></CycloneDDS>"
)

import numpy as np
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

import messages as m

RESOLUTION_M = 0.1
COLUMNS, ROWS = 120, 70
STEP_S = 0.02
# The base's own time-out of cmd_vel.
COMMAND_TIMEOUT_S = 0.5
BEAMS = 240
REACH_M = 12.0

SETTINGS = """
[local]
vx_samples = 12
vtheta_samples = 24

[navigator]
sensor_fault_patience_s = 30.0
parking_timeout_s = 3.0

[node]
network_memory_mib = 256
"""

BEST_EFFORT = Qos(Policy.Reliability.BestEffort, Policy.History.KeepLast(5))
RELIABLE = Qos(Policy.Reliability.Reliable(duration(milliseconds=100)), Policy.History.KeepLast(10))
LATCHED = Qos(
    Policy.Reliability.Reliable(duration(milliseconds=100)),
    Policy.Durability.TransientLocal,
    Policy.History.KeepLast(1),
)


def world():
    """A room of 12 by 7 m with a wall half across it."""
    cells = np.zeros((ROWS, COLUMNS), dtype=np.int8)
    cells[0, :] = cells[-1, :] = cells[:, 0] = cells[:, -1] = 100
    cells[0:35, 58:62] = 100
    return cells


def stamp():
    now = time.time_ns()
    return m.Time(now // 1_000_000_000, now % 1_000_000_000)


def header(frame):
    return m.Header(stamp(), frame)


def facing(yaw):
    return m.Quaternion(0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))


def pose(x, y, yaw):
    return m.Pose(m.Vector3(x, y, 0.0), facing(yaw))


class Robot:
    """Executes cmd_vel and publishes its measurements."""

    def __init__(self, stamped=False, namespace="", remapped=(), frame="map", place=(0.0, 0.0, 0.0)):
        self.participant = DomainParticipant(0)
        self.namespace, self.remapped = namespace, dict(remapped)
        self.frame, self.place = frame, place
        self.cells = world()
        self.x, self.y, self.yaw = 2.5, 2.0, 0.0
        self.v = self.w = 0.0
        self.has_scan = self.has_odometry = True
        self.commands, self.contacts, self.steps = [], 0, 0
        kind = m.TwistStamped if stamped else m.Twist
        self.commanded = self.reader("cmd_vel", kind, RELIABLE)
        self.odom = self.writer("odom", m.Odometry, RELIABLE)
        self.scan = self.writer("scan", m.LaserScan, BEST_EFFORT)
        self.goal = self.writer("goal_pose", m.PoseStamped, RELIABLE)
        self.tf = self.writer("tf_static", m.TFMessage, LATCHED)
        self.map = None
        self.next_s = time.monotonic()

    def topic(self, name, kind):
        full = self.remapped.get(name, f"{self.namespace}/{name}")
        return Topic(self.participant, f"rt{full}", kind)

    def reader(self, name, kind, qos):
        return DataReader(self.participant, self.topic(name, kind), qos=qos)

    def writer(self, name, kind, qos):
        return DataWriter(self.participant, self.topic(name, kind), qos=qos)

    def publish_map(self):
        self.map = self.map or self.writer("map", m.OccupancyGrid, LATCHED)
        info = m.MapMetaData(stamp(), RESOLUTION_M, COLUMNS, ROWS, pose(0.0, 0.0, 0.0))
        self.map.write(m.OccupancyGrid(header("map"), info, self.cells.flatten().tolist()))

    def publish_frames(self, mount, localized=True):
        """The lidar on the robot, and the odometry frame in the map frame unless the node measures it."""
        def transform(parent, child, x, y, yaw):
            place = m.Transform(m.Vector3(x, y, 0.0), facing(yaw))
            return m.TransformStamped(header(parent), child, place)

        frames = [transform("base_link", "laser", *mount)]
        if localized:
            frames.append(transform("map", self.frame, *self.place))
        self.tf.write(m.TFMessage(frames))

    def send_goal(self, x, y, yaw):
        self.goal.write(m.PoseStamped(header("map"), pose(x, y, yaw)))

    def ranges(self, mount):
        reach = np.arange(0.05, REACH_M, 0.03)
        angles = self.yaw + mount[2] - math.pi + np.arange(BEAMS) * (2 * math.pi / BEAMS)
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        x0, y0 = self.x + c * mount[0] - s * mount[1], self.y + s * mount[0] + c * mount[1]
        x = x0 + np.outer(np.cos(angles), reach)
        y = y0 + np.outer(np.sin(angles), reach)
        columns = np.clip((x / RESOLUTION_M).astype(int), 0, COLUMNS - 1)
        rows = np.clip((y / RESOLUTION_M).astype(int), 0, ROWS - 1)
        hit = self.cells[rows, columns] > 50
        first = hit.argmax(axis=1)
        return np.where(hit.any(axis=1), reach[first], np.inf).tolist()

    def step(self, mount=(0.0, 0.0, 0.0)):
        """Simulates 20 ms in real time."""
        self.next_s += STEP_S
        time.sleep(max(0.0, self.next_s - time.monotonic()))
        if time.monotonic() - self.next_s > 0.5:
            self.next_s = time.monotonic()
        for command in self.commanded.take(N=20):
            twist = getattr(command, "twist", command)
            if not hasattr(twist, "linear"):
                # The end of a writer, not a command.
                continue
            self.v, self.w = twist.linear.x, twist.angular.z
            self.commands.append((time.monotonic(), self.v, self.w))
        if self.commands and time.monotonic() - self.commands[-1][0] > COMMAND_TIMEOUT_S:
            self.v = self.w = 0.0
        middle = self.yaw + self.w * STEP_S / 2
        self.x += self.v * STEP_S * math.cos(middle)
        self.y += self.v * STEP_S * math.sin(middle)
        self.yaw += self.w * STEP_S
        row, column = int(self.y / RESOLUTION_M), int(self.x / RESOLUTION_M)
        self.contacts += int(self.cells[row, column] > 50)
        if self.has_odometry:
            self.odom.write(self.odometry())
        if self.has_scan and self.steps % 5 == 0:
            step = 2 * math.pi / BEAMS
            self.scan.write(m.LaserScan(
                header("laser"), -math.pi, math.pi - step, step, 0.0, 0.1, 0.05, REACH_M,
                self.ranges(mount), [],
            ))
        self.steps += 1

    def odometry(self):
        """The pose in the odometry frame."""
        px, py, pyaw = self.place
        dx, dy, c, s = self.x - px, self.y - py, math.cos(pyaw), math.sin(pyaw)
        there = pose(c * dx + s * dy, c * dy - s * dx, self.yaw - pyaw)
        twist = m.Twist(m.Vector3(self.v, 0.0, 0.0), m.Vector3(0.0, 0.0, self.w))
        none = [0.0] * 36
        return m.Odometry(
            header(self.frame), "base_link",
            m.PoseWithCovariance(there, none), m.TwistWithCovariance(twist, none),
        )

    def until(self, done, within_s, **how):
        """Steps until a condition holds. Returns the duration, or None after the time limit."""
        began = time.monotonic()
        while time.monotonic() - began < within_s:
            self.step(**how)
            if done():
                return time.monotonic() - began
        return None

    def is_commanded_to_stop(self):
        return bool(self.commands) and self.commands[-1][1:] == (0.0, 0.0)

    def away_m(self, x, y):
        return math.hypot(self.x - x, self.y - y)

    def stands_near(self, x, y):
        return self.away_m(x, y) < 0.3 and self.is_commanded_to_stop()


class Program:
    """`inbye node`, armed at its start unless `arm` is false."""

    def __init__(self, program, *arguments, arm=True, settings=""):
        self.settings = tempfile.NamedTemporaryFile("w", suffix=".toml")
        self.settings.write(settings + SETTINGS)
        self.settings.flush()
        self.child = subprocess.Popen(
            [program, "node", "--json", "--engine", "cpu", "--threads", "1",
             "--config", self.settings.name, *(["--arm"] if arm else []), *arguments],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        )

    def end(self):
        self.child.send_signal(signal.SIGINT)
        out, notices = self.child.communicate(timeout=20)
        return {"status": self.child.returncode, "stats": json.loads(out or "null"), "notices": notices.splitlines()}


GOAL = (9.0, 2.0, -1.0)


def drives_to_goal(program):
    """A goal with tf, a lidar off the robot's origin, a namespace and stamped velocities."""
    mount = (0.25, 0.1, 0.5)
    robot = Robot(stamped=True, namespace="/rover", frame="odom", place=(1.0, 0.5, 0.4))
    robot.publish_map()
    robot.publish_frames(mount)
    node = Program(program, "--namespace", "/rover", "--stamped")
    markers = robot.reader("local_markers", m.MarkerArray, RELIABLE)
    robot.until(lambda: False, 2.0, mount=mount)
    silent = len(robot.commands)
    robot.send_goal(*GOAL)
    shown = set()

    def stands():
        for array in markers.take(N=20):
            shown.update((marker.ns, marker.type, len(marker.points)) for marker in array.markers)
        return robot.stands_near(*GOAL[:2])

    took_s = robot.until(stands, 90.0, mount=mount)
    # Zero velocity for a second, then silence: another may drive. The robot may correct its place before.
    newest = [len(robot.commands), time.monotonic()]

    def is_silent():
        if len(robot.commands) != newest[0]:
            newest[:] = len(robot.commands), time.monotonic()
        return time.monotonic() - newest[1] > 1.0

    robot.until(is_silent, 30.0, mount=mount)
    count = len(robot.commands)
    robot.until(lambda: False, 1.0, mount=mount)
    error = (robot.yaw - GOAL[2] + math.pi) % (2 * math.pi) - math.pi
    return {
        "commands_before_goal": silent,
        "took_s": took_s,
        "away_m": robot.away_m(*GOAL[:2]),
        "yaw_error": error,
        "contacts": robot.contacts,
        "markers": sorted(shown),
        "commands_after_end": len(robot.commands) - count,
        **node.end(),
    }


def remapped_names(program):
    """A namespace and two topics of other names, as a launch file gives them, and a driver that wants stamped velocities."""
    remapped = {"scan": "/front/scan", "cmd_vel": "/base/cmd_vel"}
    robot = Robot(namespace="/robot1", remapped=remapped)
    robot.publish_map()
    robot.publish_frames((0.0, 0.0, 0.0))
    rules = ["__ns:=/robot1", *(f"{name}:={full}" for name, full in remapped.items())]
    node = Program(program, "--ros-args", *(word for rule in rules for word in ("-r", rule)))
    diagnostics = robot.reader("diagnostics", m.DiagnosticArray, RELIABLE)
    last = [""]

    def has_type_conflict():
        for array in diagnostics.take(N=20):
            for status in getattr(array, "status", []):
                if status.name == "inbye: other nodes":
                    last[0] = status.message
        return "TwistStamped" in last[0]

    robot.until(lambda: False, 2.0)
    had_conflict = has_type_conflict()
    driver = robot.reader("cmd_vel", m.TwistStamped, RELIABLE)
    warned_s = robot.until(has_type_conflict, 5.0)
    del driver
    left_s = robot.until(lambda: not has_type_conflict(), 5.0)
    robot.send_goal(*GOAL)
    return {
        "had_conflict": had_conflict,
        "warned_s": warned_s,
        "left_s": left_s,
        "took_s": robot.until(lambda: robot.stands_near(*GOAL[:2]), 90.0),
        "contacts": robot.contacts,
        **node.end(),
    }


def localizes(program):
    """The node finds the robot by its scans, a rough pose from the operator helps, and tf has the result."""
    place = (1.0, 0.5, 0.4)
    robot = Robot(frame="odom", place=place)
    robot.publish_map()
    robot.publish_frames((0.0, 0.0, 0.0), localized=False)
    node = Program(program, settings='pose_source = "scans"\n')
    hint = robot.writer("initialpose", m.PoseWithCovarianceStamped, RELIABLE)
    transforms = robot.reader("tf", m.TFMessage, RELIABLE)
    robot.until(lambda: False, 2.0)
    covariance = [0.0] * 36
    covariance[0] = covariance[7] = 0.25
    covariance[35] = 0.07
    rough = m.PoseWithCovariance(pose(robot.x + 0.3, robot.y - 0.2, robot.yaw + 0.2), covariance)
    hint.write(m.PoseWithCovarianceStamped(header("map"), rough))
    robot.send_goal(*GOAL)
    errors = []

    def stands():
        for message in transforms.take(N=20):
            for stamped in getattr(message, "transforms", []):
                at = stamped.transform.translation
                assert (stamped.header.frame_id, stamped.child_frame_id) == ("map", "odom")
                errors.append(distance((at.x, at.y), place))
        return robot.stands_near(*GOAL[:2])

    took_s = robot.until(stands, 90.0)
    away_m = robot.away_m(*GOAL[:2])
    diagnostics = robot.reader("diagnostics", m.DiagnosticArray, RELIABLE)
    last = [""]

    def others():
        for array in diagnostics.take(N=20):
            for status in getattr(array, "status", []):
                if status.name == "inbye: other nodes":
                    last[0] = status.message
        return "on cmd_vel too" in last[0], "on tf too" in last[0]

    # Another node drives the robot, and another one localises it.
    other = robot.writer("cmd_vel", m.Twist, RELIABLE)
    at = m.Transform(m.Vector3(0.0, 0.0, 0.0), facing(0.0))
    localization = robot.writer("tf", m.TFMessage, RELIABLE)
    robot.until(lambda: False, 1.0)
    localization.write(m.TFMessage([m.TransformStamped(header("map"), "odom", at)]))
    warned_s = robot.until(lambda: others() == (True, True), 5.0)
    del other
    left_s = robot.until(lambda: not others()[0], 5.0)
    return {
        "took_s": took_s,
        "away_m": away_m,
        "warned_s": warned_s,
        "left_s": left_s,
        "contacts": robot.contacts,
        "transforms": len(errors),
        "largest_error_m": max(errors, default=None),
        **node.end(),
    }


class Client:
    """A client of services."""

    CLIENT = 0x1234_5678_9ABC_DEF0

    def __init__(self, robot, folder, kinds):
        self.robot, self.number, self.services = robot, 0, {}
        self.depth = Qos(Policy.Reliability.Reliable(duration(milliseconds=100)), Policy.History.KeepLast(50))
        for name, (request, reply) in kinds.items():
            requests = Topic(robot.participant, f"rq/{folder}/{name}Request", request)
            replies = Topic(robot.participant, f"rr/{folder}/{name}Reply", reply)
            writer = DataWriter(robot.participant, requests, qos=self.depth)
            self.services[name] = (request, writer, DataReader(robot.participant, replies, qos=self.depth))

    def call(self, name, *arguments):
        """Sends a request and returns its number."""
        request, writer, _ = self.services[name]
        self.number += 1
        writer.write(request(self.CLIENT, self.number, *arguments))
        return self.number

    def reply(self, name, number, within_s):
        """Steps until the reply to a request."""
        got = []

        def has_reply():
            for reply in self.services[name][2].take(N=10):
                if (getattr(reply, "client", None), getattr(reply, "number", None)) == (self.CLIENT, number):
                    got.append(reply)
            return got

        self.robot.until(has_reply, within_s)
        return got[0] if got else None


class ActionClient(Client):
    """A client of the action `navigate_to_pose`."""

    def __init__(self, robot):
        action = "navigate_to_pose/_action"
        super().__init__(robot, action, {
            "send_goal": (m.SendGoalRequest, m.SendGoalReply),
            "cancel_goal": (m.CancelGoalRequest, m.CancelGoalReply),
            "get_result": (m.GetResultRequest, m.GetResultReply),
        })
        self.feedback = robot.reader(f"{action}/feedback", m.Feedback, self.depth)
        self.statuses = robot.reader(f"{action}/status", m.GoalStatusArray, LATCHED)

    def send_goal(self, number, x, y, yaw):
        """The identity of a goal, and whether it is accepted."""
        goal_id = [number] * 16
        pose_stamped = m.PoseStamped(header("map"), pose(x, y, yaw))
        reply = self.reply("send_goal", self.call("send_goal", goal_id, pose_stamped, ""), 10.0)
        return goal_id, reply and reply.accepted


def managed(program):
    """A lifecycle manager configures and activates the node, deactivates it during a drive, and shuts it down."""
    os.environ["RMW_IMPLEMENTATION"] = "rmw_cyclonedds_cpp"
    robot = Robot()
    robot.publish_map()
    robot.publish_frames((0.0, 0.0, 0.0))
    node = Program(program, "--managed")
    manager = Client(robot, "inbye", {
        "change_state": (m.ChangeStateRequest, m.ChangeStateReply),
        "get_state": (m.GetStateRequest, m.GetStateReply),
    })
    robot.until(lambda: False, 3.0)

    def change(transition, label=""):
        reply = manager.reply("change_state", manager.call("change_state", transition, label), 10.0)
        return reply and reply.success

    def state():
        reply = manager.reply("get_state", manager.call("get_state", 0), 10.0)
        return reply and [reply.state, reply.label]

    states, changes = [state()], [change(3)]
    robot.send_goal(*GOAL)
    robot.until(lambda: False, 1.0)
    facts = {"commands_before": len(robot.commands)}
    changes += [change(1), change(0, "activate")]
    states.append(state())
    robot.send_goal(*GOAL)
    facts["started_s"] = robot.until(lambda: robot.v > 0.3, 20.0)
    changes.append(change(4))
    states.append(state())
    facts["stopped_s"] = robot.until(robot.is_commanded_to_stop, 10.0)
    changes.append(change(6))
    began = time.monotonic()
    while node.child.poll() is None and time.monotonic() - began < 20.0:
        robot.step()
    return {
        **facts, "states": states, "changes": changes, "has_ended": node.child.poll() is not None,
        "contacts": robot.contacts, **node.end(),
    }


def navigates(program):
    """A client of the action cancels its first goal and reaches its second one."""
    os.environ["RMW_IMPLEMENTATION"] = "rmw_cyclonedds_cpp"
    robot = Robot()
    robot.publish_map()
    robot.publish_frames((0.0, 0.0, 0.0))
    node = Program(program)
    client = ActionClient(robot)
    robot.until(lambda: False, 3.0)
    first, accepted = client.send_goal(1, *GOAL)
    facts = {"first_accepted": accepted}
    wanted = client.call("get_result", first)
    facts["started_s"] = robot.until(lambda: robot.v > 0.3, 20.0)
    cancel = client.call("cancel_goal", m.GoalInfo(first, m.Time(0, 0)))
    answer = client.reply("cancel_goal", cancel, 10.0)
    facts["cancel_code"] = answer and answer.return_code
    facts["canceling"] = answer and [list(info.goal_id) == first for info in answer.goals_canceling]
    result = client.reply("get_result", wanted, 20.0)
    facts["first_status"] = result and result.status
    robot.until(robot.is_commanded_to_stop, 5.0)
    stood_at = (robot.x, robot.y)
    robot.until(lambda: False, 1.0)
    facts["crept_m"] = distance(stood_at, (robot.x, robot.y))
    second, facts["second_accepted"] = client.send_goal(2, *GOAL)
    client.feedback.take(N=50)
    left_m = []

    def ends():
        for message in client.feedback.take(N=50):
            if list(getattr(message, "goal_id", [])) == second:
                left_m.append(message.distance_remaining)
        return robot.stands_near(*GOAL[:2])

    facts["took_s"] = robot.until(ends, 90.0)
    result = client.reply("get_result", client.call("get_result", second), 20.0)
    facts["second_status"] = result and result.status
    facts["second_error"] = result and [result.error_code, result.error_msg]
    statuses = [one for array in client.statuses.take(N=10) for one in getattr(array, "status_list", [])]
    facts["statuses"] = sorted({(one.goal_info.goal_id[0], one.status) for one in statuses})
    facts["feedback"] = [len(left_m), left_m[0] if left_m else None, left_m[-1] if left_m else None]
    third, facts["third_accepted"] = client.send_goal(3, math.nan, 0.0, 0.0)
    # The network process ends during a goal: the new one knows its end, and the robot stands.
    fourth, facts["fourth_accepted"] = client.send_goal(4, 2.5, 2.0, 0.0)
    facts["fourth_started_s"] = robot.until(lambda: abs(robot.v) + abs(robot.w) > 0.2, 20.0)
    wanted = client.call("get_result", fourth)
    robot.until(lambda: False, 0.5)
    for child in children(node.child.pid):
        os.kill(child, signal.SIGKILL)
    robot.until(lambda: False, 6.0)
    result = client.reply("get_result", wanted, 10.0)
    facts["open_request_end"] = result and [result.status, result.error_code]
    result = client.reply("get_result", client.call("get_result", fourth), 10.0)
    facts["fourth_end"] = result and [result.status, result.error_code, result.error_msg]
    cancel = client.call("cancel_goal", m.GoalInfo(fourth, m.Time(0, 0)))
    answer = client.reply("cancel_goal", cancel, 10.0)
    facts["late_cancel_code"] = answer and answer.return_code
    stood_at = (robot.x, robot.y)
    robot.until(lambda: False, 2.0)
    facts["crept_after_restart_m"] = distance(stood_at, (robot.x, robot.y))
    return {**facts, "contacts": robot.contacts, **node.end()}


def late_joiner(program):
    """The map is older than the node, the plan older than its reader, and the node's control process comes late to its inputs."""
    robot = Robot()
    robot.publish_map()
    robot.publish_frames((0.0, 0.0, 0.0))
    robot.until(lambda: False, 3.0)
    node = Program(program)
    pid = node.child.pid
    robot.until(lambda: children(pid), 5.0)
    os.kill(pid, signal.SIGSTOP)
    robot.until(lambda: False, 2.0)
    os.kill(pid, signal.SIGCONT)
    robot.until(lambda: False, 0.5)
    robot.send_goal(*GOAL)
    started_s = robot.until(lambda: robot.v > 0.2, 20.0)
    plans = robot.reader("plan", m.Path, LATCHED)
    got = []
    plan_s = robot.until(lambda: got.extend(plans.take(N=5)) or got, 10.0)
    points = [(p.pose.position.x, p.pose.position.y) for p in got[0].poses] if got else []
    # Ctrl-C during the drive: the last command is zero.
    moving = robot.v
    ended = node.end()
    robot.until(lambda: False, 0.5)
    return {
        "started_s": started_s,
        "plan_s": plan_s,
        "plan_from_m": distance(points[0], (2.5, 2.0)) if points else None,
        "plan_to_m": distance(points[-1], GOAL) if points else None,
        "plan_frame": got[0].header.frame_id if got else None,
        "speed_at_end": moving,
        "last_command": robot.commands[-1][1:] if robot.commands else None,
        **ended,
    }


def distance(one, other):
    return math.hypot(one[0] - other[0], one[1] - other[1])


def missing_inputs(program):
    """Scans stop during the drive and return; then odometry."""
    robot, node, facts = driving(program)
    for input in ("scan", "odometry"):
        setattr(robot, f"has_{input}", False)
        facts[f"{input}_speed"] = robot.v
        facts[f"{input}_zero_s"] = robot.until(robot.is_commanded_to_stop, 10.0)
        stood_at = (robot.x, robot.y)
        robot.until(lambda: False, 1.0)
        facts[f"{input}_crept_m"] = distance(stood_at, (robot.x, robot.y))
        setattr(robot, f"has_{input}", True)
        facts[f"{input}_resumed_s"] = robot.until(lambda: robot.v > 0.3, 20.0)
    facts["took_s"] = robot.until(lambda: robot.stands_near(*GOAL[:2]), 90.0)
    return {**facts, "contacts": robot.contacts, **node.end()}


def invalid_messages(program):
    """Invalid messages are rejected and reported; the robot does not move."""
    robot = Robot()
    node = Program(program)
    best_effort = robot.writer("goal_pose", m.PoseStamped, Qos(Policy.Reliability.BestEffort))
    robot.until(lambda: False, 2.0)
    goal = m.PoseStamped(header("odom"), pose(*GOAL))
    best_effort.write(goal)
    robot.cells[3, 4] = 101
    robot.publish_map()
    robot.until(lambda: False, 0.5)
    robot.cells[3, 4] = 0
    robot.publish_map()
    robot.until(lambda: False, 0.5)
    for _ in range(3):
        robot.goal.write(goal)
        robot.until(lambda: False, 0.2)
    goal.header.frame_id, goal.pose.position.x = "map", math.nan
    robot.goal.write(goal)
    robot.until(lambda: False, 0.5)
    return {"commands": len(robot.commands), **node.end()}


def heartbeat(writer_guid, first, last, count):
    """The RTPS message of 52 bytes in which a writer offers the samples `first` to `last` (RTPS 2.5, 8.3.8.6)."""
    message = b"RTPS" + bytes([2, 1, 1, 16]) + writer_guid[:12]
    number = lambda value: struct.pack("<iI", value >> 32, value & 0xFFFFFFFF)
    body = bytes(4) + writer_guid[12:] + number(first) + number(last) + struct.pack("<i", count)
    return message + struct.pack("<BBH", 0x07, 0x01, len(body)) + body


def children(pid):
    """Processes that a process has started."""
    with open(f"/proc/{pid}/task/{pid}/children") as file:
        return [int(word) for word in file.read().split()]


def memory_kib(pid):
    with open(f"/proc/{pid}/status") as file:
        lines = dict(line.split(":", 1) for line in file if ":" in line)
    return int(lines["VmRSS"].split()[0])


class Memory(threading.Thread):
    """The largest memory of the node's two processes, sampled."""

    def __init__(self, pid):
        super().__init__(daemon=True)
        self.pid, self.control_kib, self.network_kib = pid, 0, 0
        self.start()

    def run(self):
        while True:
            try:
                self.control_kib = max(self.control_kib, memory_kib(self.pid))
                for child in children(self.pid):
                    self.network_kib = max(self.network_kib, memory_kib(child))
            except (OSError, KeyError, ValueError):
                pass
            time.sleep(0.005)


def driving(program):
    """A robot on the move, its node, and facts."""
    robot = Robot()
    robot.publish_map()
    robot.publish_frames((0.0, 0.0, 0.0))
    node = Program(program)
    robot.until(lambda: False, 2.0)
    robot.send_goal(*GOAL)
    return robot, node, {"started_s": robot.until(lambda: robot.v > 0.3, 20.0)}


def zeros_after_loss(robot, node, lost, facts):
    """Waits for the next network process, for its zeros, and for the goal. Commands of the lost one do not count."""
    facts["lost_s"] = robot.until(lambda: children(node.child.pid) != lost, 20.0)
    count = len(robot.commands)
    facts["zero_s"] = robot.until(lambda: len(robot.commands) > count and robot.is_commanded_to_stop(), 30.0)
    facts["first_after"] = robot.commands[count][1:] if len(robot.commands) > count else None
    facts["resumed_s"] = robot.until(lambda: robot.v > 0.3, 30.0)
    facts["took_s"] = robot.until(lambda: robot.stands_near(*GOAL[:2]), 90.0)


def endless_heartbeat(program):
    """A known writer offers 2^32 samples, in one message of 52 bytes."""
    robot, node, facts = driving(program)
    memory = Memory(node.child.pid)
    packet = heartbeat(robot.map.guid.bytes, 1, 2**32, 2**30)
    sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton("127.0.0.1"))
    lost = children(node.child.pid)
    sender.sendto(packet, ("239.255.0.1", 7400))
    zeros_after_loss(robot, node, lost, facts)
    return {
        **facts, "bytes": len(packet), "contacts": robot.contacts,
        "control_mib": memory.control_kib / 1024, "network_mib": memory.network_kib / 1024, **node.end(),
    }


def network_process_hangs(program):
    """The network process is stopped during the drive."""
    robot, node, facts = driving(program)
    lost = children(node.child.pid)
    for child in lost:
        os.kill(child, signal.SIGSTOP)
    zeros_after_loss(robot, node, lost, facts)
    return {**facts, "contacts": robot.contacts, **node.end()}


def control_process_dies(program):
    """The control process is killed during the drive, or only stopped: the network process publishes zeros."""
    robot, node, facts = driving(program)
    pid, network = node.child.pid, children(node.child.pid)
    for name, number in (("stopped", signal.SIGSTOP), ("killed", signal.SIGKILL)):
        facts[f"{name}_speed"] = robot.v
        began_s = time.monotonic()
        os.kill(pid, number)
        zero = lambda: any(at > began_s and (v, w) == (0.0, 0.0) for at, v, w in robot.commands)
        facts[f"{name}_zero_s"] = robot.until(zero, 10.0)
        if number == signal.SIGSTOP:
            os.kill(pid, signal.SIGCONT)
            facts["resumed_s"] = robot.until(lambda: robot.v > 0.3, 30.0)
    node.child.wait(timeout=10)
    robot.until(lambda: not any(os.path.exists(f"/proc/{child}") for child in network), 10.0)
    facts["orphans"] = [child for child in network if os.path.exists(f"/proc/{child}")]
    return {**facts, "contacts": robot.contacts}


# How long packets are mutated, seconds; an hour for a search.
FUZZ_S = float(os.environ.get("INBYE_PACKET_SECONDS", "6"))
# Mutated packets each second.
FUZZ_RATE = 400


def udp_ports(pid):
    """The UDP ports that a process has bound."""
    sockets = set()
    for name in os.listdir(f"/proc/{pid}/fd"):
        try:
            sockets.add(os.readlink(f"/proc/{pid}/fd/{name}")[8:-1])
        except OSError:
            pass
    with open("/proc/net/udp") as file:
        rows = [line.split() for line in file][1:]
    return {int(row[1].split(":")[1], 16) for row in rows if row[9] in sockets}


def mutated(packet, random):
    """An RTPS packet with a few changes: bits, numbers, lengths, order and end of its submessages."""
    packet = bytearray(packet)
    for _ in range(random.choice([1, 1, 2, 4, 16])):
        at = random.randrange(4, len(packet))
        match random.randrange(6):
            case 0:
                packet[at] ^= 1 << random.randrange(8)
            case 1:
                packet[at] = random.choice([0, 1, 0x7F, 0x80, 0xFF])
            case 2:
                packet[at : at + 4] = struct.pack("<I", random.choice([0, 1, 2**31 - 1, 2**31, 2**32 - 1]))
            case 3:
                del packet[max(20, at) :]
            case 4:
                packet[at:at] = packet[20 : 20 + random.randrange(64)]
            case 5:
                packet[at : at + 8] = random.randbytes(8)
        if len(packet) < 24:
            break
    return bytes(packet)


class Mutator(threading.Thread):
    """Mutates the packets of the loopback and sends them to the node, until it is ended."""

    def __init__(self, pid):
        super().__init__(daemon=True)
        self.pid, self.random, self.sent, self.ends = pid, random.Random(1), 0, False
        self.taps = socket.socket(socket.AF_PACKET, socket.SOCK_DGRAM, socket.htons(0x0800))
        self.taps.bind(("lo", 0))
        self.taps.settimeout(0.05)
        self.sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.start()

    def run(self):
        seen, ports, looked_s, begun_s = [], [], 0.0, time.monotonic()
        while not self.ends:
            try:
                packet = self.taps.recv(65536)
                begin = 4 * (packet[0] & 15) + 8
                if packet[begin : begin + 4] == b"RTPS":
                    seen = (seen + [packet[begin:]])[-300:]
            except TimeoutError:
                pass
            if time.monotonic() - looked_s > 0.5:
                try:
                    own = udp_ports(os.getpid())
                    ports = [port for child in children(self.pid) for port in udp_ports(child) if port not in own]
                except OSError:
                    ports = []
                looked_s = time.monotonic()
            while seen and ports and self.sent < FUZZ_RATE * (time.monotonic() - begun_s):
                packet = mutated(self.random.choice(seen), self.random)
                try:
                    self.sender.sendto(packet, ("127.0.0.1", self.random.choice(ports)))
                except OSError:
                    pass
                self.sent += 1


def mutated_packets(program):
    """Mutated packets come all the time, while the robot drives to and fro. Then they end, and the node drives to its goal."""
    robot, node, facts = driving(program)
    memory = Memory(node.child.pid)
    mutator = Mutator(node.child.pid)
    ends_s = time.monotonic() + FUZZ_S
    fastest, losses, network, goals = 0.0, 0, children(node.child.pid), 0
    while time.monotonic() < ends_s:
        goals += 1
        goal = GOAL if goals % 2 else (2.5, 2.0, 0.0)
        robot.send_goal(*goal)
        robot.until(lambda: robot.stands_near(*goal[:2]), min(30.0, max(1.0, ends_s - time.monotonic())))
        fastest = max([fastest, *(abs(v) for _, v, _ in robot.commands)])
        del robot.commands[:-50]
        if (now := children(node.child.pid)) != network:
            network, losses = now, losses + 1
        if node.child.poll() is not None:
            break
    mutator.ends = True
    mutator.join()
    robot.until(lambda: False, 3.0)
    robot.send_goal(*GOAL)
    facts["took_s"] = robot.until(lambda: robot.stands_near(*GOAL[:2]), 90.0)
    return {
        **facts, "packets": mutator.sent, "goals": goals, "network_losses": losses, "fastest": fastest,
        "contacts": robot.contacts, "control_mib": memory.control_kib / 1024, "network_mib": memory.network_kib / 1024,
        **node.end(),
    }


OPERATOR_PORT = 8765


def request(method, path):
    """The operator's state by the answer to a request."""
    url = f"http://127.0.0.1:{OPERATOR_PORT}{path}"
    with urllib.request.urlopen(urllib.request.Request(url, method=method), timeout=5) as answer:
        return json.load(answer)["state"]


def arming(program):
    """A goal does not arm the robot; a message and a request arm it and stop it."""
    robot = Robot()
    robot.publish_map()
    robot.publish_frames((0.0, 0.0, 0.0))
    node = Program(program, "--operator-port", str(OPERATOR_PORT), arm=False)
    arm, stop = (robot.writer(f"inbye/{name}", m.Bool, RELIABLE) for name in ("arm", "stop"))
    every = Qos(Policy.Reliability.Reliable(duration(milliseconds=100)), Policy.History.KeepAll)
    diagnostics = robot.reader("diagnostics", m.DiagnosticArray, every)
    robot.until(lambda: False, 2.0)
    robot.send_goal(*GOAL)
    robot.until(lambda: False, 3.0)
    facts = {"unarmed_commands": len(robot.commands), "unarmed_m": robot.away_m(2.5, 2.0)}
    states = [request("GET", "/status")]
    means = {
        "message": (lambda: arm.write(m.Bool(True)), lambda: stop.write(m.Bool(True))),
        "request": (lambda: request("POST", "/arm"), lambda: request("POST", "/stop")),
    }
    for name, (arms, stops) in means.items():
        arms()
        facts[f"{name}_armed_s"] = robot.until(lambda: robot.v > 0.3, 20.0)
        stops()
        facts[f"{name}_stopped_s"] = robot.until(robot.is_commanded_to_stop, 10.0)
        stood_at = (robot.x, robot.y)
        robot.send_goal(*GOAL)
        robot.until(lambda: False, 1.5)
        facts[f"{name}_crept_m"] = distance(stood_at, (robot.x, robot.y))
        states.append(request("GET", "/status"))
    states.append(request("POST", "/arm"))
    facts["took_s"] = robot.until(lambda: robot.stands_near(*GOAL[:2]), 90.0)
    shown = [one for array in diagnostics.take(N=1000) for one in array.status]
    operators = [value.value for one in shown for value in one.values if value.key == "operator"]
    return {
        **facts, "states": states, "operators": sorted(set(operators)), "contacts": robot.contacts, **node.end(),
    }


if __name__ == "__main__":
    program, scenario = sys.argv[1:]
    print(json.dumps(globals()[scenario](program)))
