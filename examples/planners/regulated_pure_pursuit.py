"""Regulated pure pursuit, Macenski, Singh, Martin and Gines 2023: slower in bends and near obstacles, stops before contact."""
import numpy as np
from controller_loop import arcs, corners_of, gaps, path_ahead, scan_points, serve

LOOKAHEAD_S, NEAREST_M, FARTHEST_M = 1.0, 0.3, 0.9
MIN_RADIUS_M, NEAR_M, NEAR_GAIN, LEAST_SPEED = 0.9, 0.6, 1.0, 0.1
ROTATE_FROM_RAD, COLLISION_S = 0.785, 1.0


def make(start):
    corners = corners_of(start)

    def decide(tick):
        limits, (v, _) = tick["limits"], tick["twist"]
        lookahead = np.clip(v * LOOKAHEAD_S, NEAREST_M, FARTHEST_M)
        x, y = path_ahead(tick, lookahead)[-1]
        points = scan_points(tick, 3.0)
        bearing = np.arctan2(y, x)
        if abs(bearing) > ROTATE_FROM_RAD:
            command = 0.0, np.copysign(min(limits["max_vel_theta"], 2.0 * abs(bearing)), bearing)
        else:
            curvature = 2.0 * y / max(x * x + y * y, 1e-9)
            speed = limits["max_vel_x"] * min(1.0, 1.0 / max(abs(curvature) * MIN_RADIUS_M, 1e-9))
            gap = gaps(np.zeros((1, 3)), points, corners)[0]
            speed *= min(1.0, NEAR_GAIN * max(gap, 0.0) / NEAR_M)
            speed = min(max(speed, LEAST_SPEED), limits["max_vel_x"])
            command = speed, speed * curvature
        ahead = arcs(np.array([command]), np.arange(0.1, COLLISION_S + 0.05, 0.1))
        return None if gaps(ahead, points, corners).min() < 0.01 else command

    return decide


serve("regulated pure pursuit", make)
