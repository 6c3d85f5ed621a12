"""Connects a controller in Python to inbye: a line of JSON in, a line of JSON out. It also turns the robot at the goal."""
import json
import math
import sys

import numpy as np

TURN_WITHIN_M, TOLERANCE_SHARE, TURN_GAIN = 0.15, 0.75, 2.0


def serve(name, make, wants=()):
    """Runs a controller until inbye ends it.

    `make(start)` gets the first message and returns a function. That gets each tick, with "path" as an array, and returns a
    velocity (m/s, rad/s), or None if there is no valid one. It does not get the ticks at which `TurnAtGoal` has a velocity.
    """
    decide, path, turn_at_goal = None, None, None
    # Once a large array is freed, glibc keeps the memory of smaller ones. It would return it to the system at each tick.
    np.empty(30_000_000, dtype=np.uint8)
    for line in sys.stdin:
        message = json.loads(line)
        if message["type"] == "start":
            decide, turn_at_goal = make(message), TurnAtGoal(message["goal_tolerance"][0])
            answer = {"protocol": 1, "name": name, "wants": list(wants)}
        else:
            path = np.array(message["path"]) if "path" in message else path
            velocity = turn_at_goal(message) or decide({**message, "path": path})
            answer = {"tick": message["tick"]}  # inbye checks that the answer is for this tick
            if velocity is None:
                answer["error"] = "no valid velocity"
            else:
                answer.update(linear=float(velocity[0]), angular=float(velocity[1]))
        print(json.dumps(answer), flush=True)


class TurnAtGoal:
    """Brakes and turns the robot in place at a goal with a yaw.

    A local planner follows a path of points, so it does not know the yaw of the goal. In Nav2, local planners turn the robot when it is
    at the goal. Here this function does it for all of them: it returns a velocity near a goal that has a yaw, and None elsewhere.

    A turn begins where the robot can stop within 0.15 m of the goal, or within three quarters of a smaller tolerance. It ends a third
    beyond: with one distance for both, noise of the pose would let planner and turn alternate.
    """

    def __init__(self, tolerance_m):
        self.within_m, self.turns = min(TURN_WITHIN_M, TOLERANCE_SHARE * tolerance_m), False

    def __call__(self, tick):
        (x, y, yaw), (v, _), limits = tick["predicted_pose"], tick["predicted_twist"], tick["limits"]
        goal_x, goal_y, goal_yaw = tick["goal"]
        braking_m = v * abs(v) / (-2 * limits["decel_lim_x"])
        distance_m = math.hypot(goal_x - x - braking_m * math.cos(yaw), goal_y - y - braking_m * math.sin(yaw))
        self.turns = goal_yaw is not None and distance_m < self.within_m / (TOLERANCE_SHARE if self.turns else 1.0)
        if not self.turns:
            return None
        error, rate = math.remainder(goal_yaw - tick["pose"][2], math.tau), limits["max_vel_theta"]
        return 0.0, min(max(TURN_GAIN * error, -rate), rate)


def scan_points(tick, farthest_m=np.inf):
    """End points of the beams in the robot's frame, metres, as an array of x and y."""
    scan = tick["scan"]
    ranges = np.array(scan["ranges"], dtype=float)  # no measurement: NaN
    angles = scan["angle_min"] + scan["angle_increment"] * np.arange(len(ranges))
    seen = ranges < min(scan["range_max"], farthest_m)
    return scan["origin"] + (ranges[:, None] * np.column_stack([np.cos(angles), np.sin(angles)]))[seen]


def in_robot_frame(points, pose):
    """Points of the map frame in the frame of a robot at a pose."""
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    return (np.atleast_2d(points) - pose[:2]) @ np.array([[cos, -sin], [sin, cos]])


def path_ahead(tick, length_m, spacing_m=0.05):
    """Points of the path from the robot on, in its frame."""
    path = tick["path"]
    arcs = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    ahead = np.arange(tick["path_progress_m"], tick["path_progress_m"] + length_m, spacing_m)
    ahead = np.append(ahead[ahead < arcs[-1]], min(arcs[-1], tick["path_progress_m"] + length_m))
    points = np.column_stack([np.interp(ahead, arcs, path[:, axis]) for axis in (0, 1)])
    return in_robot_frame(points, tick["pose"])


def arcs(velocities, times):
    """Poses on arcs of constant velocity from the robot on: an array [velocity, time, (x, y, yaw)]."""
    v, w = velocities[:, :1], velocities[:, 1:]
    yaw = w * times
    bend = np.where(np.abs(w) < 1e-6, 1e-6, w)
    return np.stack([v / bend * np.sin(bend * times), v / bend * (1 - np.cos(bend * times)), yaw], axis=-1)


def nearest(points, others):
    """Distance of each point from the nearest of the others."""
    x, y = points.T
    return np.sqrt(((others[:, :1] - x) ** 2 + (others[:, 1:] - y) ** 2).min(axis=0))


def gaps(poses, points, corners, enough_m=np.inf):
    """Smallest distance of the points from a rectangle at each pose; negative inside. `corners` are those of its body.

    A distance above `enough_m` may come out larger, up to infinity. That takes less time.
    """
    if len(points) == 0:
        return np.full(poses.shape[:-1], np.inf)
    middle, half = (corners.max(axis=0) + corners.min(axis=0)) / 2, np.ptp(corners, axis=0) / 2
    # Blocks of poses that lie close together: by strips across x, and by y in each.
    columns = poses.reshape(-1, 3).T
    order = np.argsort(np.round(columns[0] / 0.25) * 1000.0 + columns[1])
    columns, starts = columns[:, order], np.arange(0, len(order), 128)
    low, high = (bound.reduceat(columns[:2], starts, axis=1)[:, :, None] for bound in (np.minimum, np.maximum))
    # Of the points, a block needs those whose smallest possible distance is at most the largest possible one of another point.
    spread, away = (high - low) / 2, np.abs(points.T[:, None] - (low + high) / 2)
    nearest_m = np.hypot(*np.maximum(away - spread, 0.0)) - np.hypot(*half) - np.hypot(*middle) - 1e-6
    farthest_m = np.hypot(*(away + spread)) - half.min() + np.hypot(*middle)
    least = np.full(len(order), np.inf)
    for start, near in zip(starts, nearest_m <= np.minimum(farthest_m.min(axis=1, keepdims=True), enough_m)):
        if near.any():
            block = slice(start, start + 128)
            (x, y, yaw), close = columns[:, block], points[near]
            cos, sin = np.cos(yaw), np.sin(yaw)
            away_x, away_y = close[:, :1] - x, close[:, 1:] - y
            outside_x = np.abs(cos * away_x + sin * away_y - middle[0]) - half[0]
            outside_y = np.abs(cos * away_y - sin * away_x - middle[1]) - half[1]
            depth = np.minimum(np.maximum(outside_x, outside_y).min(axis=0), 0.0)
            squared = np.maximum(outside_x, 0.0) ** 2 + np.maximum(outside_y, 0.0) ** 2
            least[order[block]] = np.sqrt(squared.min(axis=0)) + depth
    return least.reshape(poses.shape[:-1])


def corners_of(start):
    """Corners of the body, or of the box around its discs."""
    robot = start["robot"]
    if robot["footprint"]:
        return np.array(robot["footprint"])
    discs = np.array([[disc["x"], disc["y"], disc["radius"]] for disc in robot["discs"]])
    low, high = (discs[:, :2] - discs[:, 2:]).min(axis=0), (discs[:, :2] + discs[:, 2:]).max(axis=0)
    return np.array([low, high])
