"""A controller without packages: drives to the local target, stops for what the lidar sees ahead, and turns at the goal."""
import json
import math
import sys

for line in sys.stdin:
    message = json.loads(line)
    if message["type"] == "start":
        near_m = 0.6 * message["goal_tolerance"][0]
        answer = {"protocol": 1, "name": "stop and go"}
    else:
        x, y, yaw = message["pose"]
        target_x, target_y = message["local_target"]
        scan = message["scan"]
        error = math.remainder(math.atan2(target_y - y, target_x - x) - yaw, math.tau)
        ahead = [
            distance
            for beam, distance in enumerate(scan["ranges"])
            if distance is not None and abs(math.remainder(scan["angle_min"] + beam * scan["angle_increment"], math.tau)) < 0.4
        ]
        clear = scan["origin"][0] + min(ahead, default=0.0) > 0.8
        answer = {"linear": 0.4 if clear and abs(error) < 0.5 else 0.0, "angular": 1.5 * error}
        goal_x, goal_y, goal_yaw = message["goal"]  # the yaw is None if every yaw is allowed
        if goal_yaw is not None and math.hypot(goal_x - x, goal_y - y) < near_m:
            answer = {"linear": 0.0, "angular": 1.5 * math.remainder(goal_yaw - yaw, math.tau)}
    print(json.dumps(answer), flush=True)
