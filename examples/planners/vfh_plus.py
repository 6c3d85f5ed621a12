"""VFH+, Ulrich and Borenstein 1998: a polar histogram of the obstacles, and the free direction with the least cost."""
import numpy as np
from controller_loop import path_ahead, scan_points, serve

SECTORS, WINDOW_M, SAFETY_M, WIDE_SECTORS = 72, 2.0, 0.1, 16
TARGET, HEADING, PREVIOUS = 5.0, 2.0, 2.0


def make(start):
    radius = start["robot"]["radius_m"] + SAFETY_M
    centers = (np.arange(SECTORS) + 0.5) * 2 * np.pi / SECTORS - np.pi
    last = [0.0]
    apart = lambda one, other: np.abs(np.angle(np.exp(1j * (one - other))))

    def decide(tick):
        limits, points = tick["limits"], scan_points(tick, WINDOW_M)
        distance = np.maximum(np.linalg.norm(points, axis=1), 1e-6)
        bearing = np.arctan2(points[:, 1], points[:, 0])
        enlarged = np.arcsin(np.minimum(radius / distance, 1.0))
        # As `apart`, without complex numbers: these are 72 angles for each point.
        between = np.abs(centers[:, None] - bearing)
        blocked = (np.minimum(between, 2 * np.pi - between) <= enlarged).any(axis=1)
        free = np.flatnonzero(~blocked)
        if len(free) == 0:
            return 0.0, limits["max_vel_theta"] / 2
        x, y = path_ahead(tick, 1.2)[-1]
        target = np.arctan2(y, x)
        # In a wide opening the direction keeps half its width from the edge; a narrow one is driven through its middle.
        sectors = np.abs(free[:, None] - np.flatnonzero(blocked))
        margin = np.minimum(sectors, SECTORS - sectors).min(axis=1, initial=WIDE_SECTORS)
        cost = TARGET * apart(centers[free], target) + HEADING * apart(centers[free], 0.0) + PREVIOUS * apart(centers[free], last[0])
        last[0] = centers[free][(cost + 0.1 * np.maximum(0, WIDE_SECTORS // 4 - margin)).argmin()]
        ahead = points[(np.abs(points[:, 1]) < radius) & (points[:, 0] > 0), 0]
        room = max(0.0, ahead.min(initial=WINDOW_M) - radius)
        speed = min(limits["max_vel_x"], np.sqrt(-2 * limits["decel_lim_x"] * 0.5 * room)) * max(0.0, np.cos(last[0])) ** 2
        return speed, np.clip(2.0 * last[0], -limits["max_vel_theta"], limits["max_vel_theta"])

    return decide


serve("VFH+", make)
