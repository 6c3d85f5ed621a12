"""The smallest simulator: a unicycle that follows each command at once, and a lidar that steps along its beams."""
import json
import math
import sys

STEP_M = 0.02


def run(start):
    grid, lidar = start["obstacles"], start["lidar"]
    occupied = [value for index, run in enumerate(grid["runs"]) for value in [index % 2 == 1] * run]
    pose = list(start["start"])
    radius = start["robot"]["radius_m"]

    def is_blocked(x, y):
        column = math.floor((x - grid["origin"][0]) / grid["resolution_m"])
        row = math.floor((y - grid["origin"][1]) / grid["resolution_m"])
        inside = 0 <= column < grid["width"] and 0 <= row < grid["height"]
        return not inside or occupied[row * grid["width"] + column]

    def distance(angle):
        cos, sin = math.cos(pose[2] + angle), math.sin(pose[2] + angle)
        steps = (step * STEP_M for step in range(int(lidar["range_max_m"] / STEP_M)))
        return next((away for away in steps if is_blocked(pose[0] + away * cos, pose[1] + away * sin)), lidar["range_max_m"])

    first, width = -lidar["field_of_view_rad"] / 2, lidar["field_of_view_rad"] / lidar["beams"]

    def step(command):
        time_s, v, w = command["period_s"], command["linear"], command["angular"]
        middle = pose[2] + w * time_s / 2
        pose[:] = [pose[0] + v * time_s * math.cos(middle), pose[1] + v * time_s * math.sin(middle), pose[2] + w * time_s]
        ranges = [distance(first + beam * width) for beam in range(lidar["beams"])]
        motion = {"pose": pose, "twist": [v, w]}
        scan = {"angle_min": first, "angle_increment": width, "range_max": lidar["range_max_m"], "ranges": ranges}
        return {"odometry": motion, "scan": scan, "truth": {**motion, "contact": min(ranges) < radius / 2}}

    return step


for line in sys.stdin:
    message = json.loads(line)
    if message["type"] == "simulate":
        step = run(message)
        print(json.dumps({"protocol": 1, "name": "unicycle"}), flush=True)
    else:
        print(json.dumps(step(message)), flush=True)
