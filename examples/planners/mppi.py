"""Model predictive path integral control, Williams, Drews, Goldfain, Rehg and Theodorou 2017, in numpy."""
import numpy as np
from controller_loop import corners_of, gaps, path_ahead, scan_points, serve

ROLLOUTS, STEPS, STEP_S, TEMPERATURE = 400, 20, 0.1, 0.3
NOISE = np.array([0.25, 0.5])
PATH, GOAL, NEAR, CONTACT, TURN = 1.5, 2.0, 0.3, 1000.0, 0.05


def make(start):
    corners, random = corners_of(start), np.random.default_rng(0)
    mean = np.zeros((STEPS, 2))

    def decide(tick):
        limits, (v, w) = tick["limits"], tick["twist"]
        mean[:-1], mean[-1] = mean[1:].copy(), mean[-1]
        controls = mean + NOISE * random.standard_normal((ROLLOUTS, STEPS, 2))
        controls[0], controls[1] = mean, 0.0
        bounds = np.array([limits["max_vel_x"], limits["max_vel_theta"]])
        controls = np.clip(controls, [min(limits["min_vel_x"], 0.0), -bounds[1]], bounds)
        change = np.array([limits["acc_lim_x"], limits["acc_lim_theta"]]) * STEP_S
        state, poses = np.tile([v, w], (ROLLOUTS, 1)), np.zeros((ROLLOUTS, STEPS, 3))
        pose = np.zeros((ROLLOUTS, 3))
        for step in range(STEPS):
            state = state + np.clip(controls[:, step] - state, -change, change)
            pose = pose + STEP_S * np.column_stack([state[:, 0] * np.cos(pose[:, 2]), state[:, 0] * np.sin(pose[:, 2]), state[:, 1]])
            poses[:, step] = pose
        path, points = path_ahead(tick, 2.0 * max(0.5, limits["max_vel_x"])), scan_points(tick, 3.0)[::2]
        gap = gaps(poses[:, ::2], points, corners)
        off = np.linalg.norm(poses[:, ::4, None, :2] - path, axis=-1).min(axis=2)
        cost = PATH * off.mean(axis=1) + GOAL * np.linalg.norm(poses[:, -1, :2] - path[-1], axis=-1)
        cost += NEAR * np.exp(-4.0 * np.maximum(gap, 0.0)).sum(axis=1) + CONTACT * (gap < 0.05).sum(axis=1)
        cost += TURN * np.abs(np.diff(controls[:, :, 1], axis=1)).sum(axis=1)
        weights = np.exp(-(cost - cost.min()) / TEMPERATURE)
        mean[:] = np.tensordot(weights / weights.sum(), controls, axes=1)
        return None if (gap[cost.argmin()] < 0.01).any() else mean[0]

    return decide


serve("MPPI", make)
