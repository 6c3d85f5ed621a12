"""Model predictive path integral control, Williams, Drews, Goldfain, Rehg and Theodorou 2017, in numpy."""
import numpy as np
from controller_loop import corners_of, gaps, nearest, path_ahead, scan_points, serve

ROLLOUTS, STEPS, STEP_S, TEMPERATURE = 400, 20, 0.1, 0.3
NOISE = np.tile([0.25, 0.5], (STEPS, 1))
PATH, GOAL, NEAR, CONTACT, TURN = 1.5, 2.0, 0.3, 1000.0, 0.05


def make(start):
    corners, random = corners_of(start), np.random.default_rng(0)
    mean = np.zeros((STEPS, 2))

    def decide(tick):
        limits, (v, w) = tick["limits"], tick["twist"]
        mean[:-1], mean[-1] = mean[1:].copy(), mean[-1]
        controls = mean + NOISE * random.standard_normal((ROLLOUTS, STEPS, 2))
        controls[0], controls[1] = mean, 0.0
        fastest, rate = limits["max_vel_x"], limits["max_vel_theta"]
        controls = np.clip(controls, np.tile([min(limits["min_vel_x"], 0.0), -rate], (STEPS, 1)), np.tile([fastest, rate], (STEPS, 1)))
        change = np.array([[limits["acc_lim_x"]], [limits["acc_lim_theta"]]]) * STEP_S
        # Arrays [step, (v, w), rollout]: numpy is fast along a long last axis.
        wanted, states = np.ascontiguousarray(controls.transpose(1, 2, 0)), np.empty((STEPS + 1, 2, ROLLOUTS))
        states[0] = [[v], [w]]
        for step in range(STEPS):
            states[step + 1] = states[step] + np.clip(wanted[step] - states[step], -change, change)
        speeds, yaws = states[1:, 0], np.zeros((STEPS + 1, ROLLOUTS))
        np.cumsum(STEP_S * states[1:, 1], axis=0, out=yaws[1:])
        moves = STEP_S * (speeds * np.cos(yaws[:-1])), STEP_S * (speeds * np.sin(yaws[:-1]))
        poses = np.stack([*np.cumsum(moves, axis=1), yaws[1:]], axis=-1).swapaxes(0, 1)
        path, points = path_ahead(tick, 2.0 * max(0.5, fastest)), scan_points(tick, 3.0)[::2]
        gap = gaps(poses[:, ::2], points, corners)
        off = np.stack([nearest(poses[:, step, :2], path) for step in range(0, STEPS, 4)], axis=1)
        cost = PATH * off.mean(axis=1) + GOAL * nearest(poses[:, -1, :2], path[-1:])
        cost += NEAR * np.exp(-4.0 * np.maximum(gap, 0.0)).sum(axis=1) + CONTACT * (gap < 0.05).sum(axis=1)
        cost += TURN * np.abs(np.diff(controls[:, :, 1], axis=1)).sum(axis=1)
        weights = np.exp(-(cost - cost.min()) / TEMPERATURE)
        mean[:] = np.tensordot(weights / weights.sum(), controls, axes=1)
        return None if (gap[cost.argmin()] < 0.01).any() else mean[0]

    return decide


serve("MPPI", make)
