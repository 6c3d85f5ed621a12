"""Compares a controller of one's own with inbye and two planners of others on 20 worlds of BARN.

Run in the repository's root: python python/examples/my_planner.py FOLDER_OF_BARN
"""

import sys

import inbye
import numpy as np


class MyPlanner:
    """Turns towards the free direction that lies nearest to the path, and slows down in curves."""

    def compute_velocity(self, seen: inbye.ControllerInput) -> tuple[float, float]:
        """Return speed and turn rate."""
        x, y, yaw = seen.pose
        beams = seen.angle_min + seen.angle_increment * np.arange(len(seen.ranges))
        ends = np.where(np.isfinite(seen.ranges), seen.ranges, seen.range_max) * np.exp(1j * beams)
        ends += complex(*seen.lidar_position)  # x + iy in the robot's frame
        ranges, angles = np.abs(ends), np.angle(ends)
        wanted = np.arctan2(seen.local_target[1] - y, seen.local_target[0] - x) - yaw
        half_width = np.arctan2(0.45, np.minimum(ranges, 2.0))
        blocked = [np.min(ranges[np.abs(angles - angle) < half_width]) < 1.2 for angle in angles]
        cost = np.abs(np.angle(np.exp(1j * (angles - wanted)))) + 10.0 * np.array(blocked)
        turn = float(angles[np.argmin(cost)])
        ahead = float(np.min(ranges[np.abs(angles) < 0.4]))
        return min(seen.speed_limits[1], 0.8 * max(ahead - 0.5, 0.0)) * max(np.cos(turn), 0.0), turn


others = {"inbye": {}}
for name in ("regulated_pure_pursuit", "vfh_plus"):
    command = [sys.executable, f"examples/planners/{name}.py"]
    others[name] = {"controller": {"command": command}}
worlds = [{"kind": "barn", "path": sys.argv[1], "only": [0, 15, 27, *range(39, 232, 12)][:20]}]
print(
    inbye.bench.compare(
        {"title": "My planner on BARN", "configs": others, "worlds": worlds},
        {"mine": MyPlanner},
        jobs=2,
        report="comparison",
    )
)
