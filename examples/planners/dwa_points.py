"""Dynamic window approach on the points of the scan, scored as by TrajectoryPlannerROS of move_base with `dwa: true`.

Fox, Burgard and Thrun 1997. Number of samples, horizon and weights are those of the BARN challenge's baseline
(`base_local_planner_params.yaml`): distance to the path, to a local goal on it, and to obstacles within 0.3 m.
"""
import numpy as np
from controller_loop import arcs, corners_of, gaps, nearest, path_ahead, scan_points, serve

SAMPLES, HORIZON_S, STEP_S = (6, 20), 2.0, 0.1
PATH, GOAL, OBSTACLE = 0.75, 1.0, 0.1
PADDING_M, INFLATION_M, LOCAL_GOAL_M = 0.1, 0.3, 2.5


def make(start):
    corners, times = corners_of(start), np.arange(STEP_S, HORIZON_S + STEP_S / 2, STEP_S)

    def decide(tick):
        limits, (v, w), period_s = tick["limits"], tick["twist"], start["period_s"]
        fastest = limits["max_vel_x"]
        speeds = np.linspace(max(min(0.1, fastest), v + limits["decel_lim_x"] * period_s), min(fastest, v + limits["acc_lim_x"] * period_s), SAMPLES[0])
        rate, step = limits["max_vel_theta"], limits["acc_lim_theta"] * period_s
        rates = np.linspace(max(-rate, w - step), min(rate, w + step), SAMPLES[1])
        samples = np.array([(v, w) for v in speeds for w in np.append(rates, 0.0)] + [(0.0, w) for w in rates if abs(w) > 0.3])
        path, points = path_ahead(tick, LOCAL_GOAL_M), scan_points(tick, fastest * HORIZON_S + 0.6)[::3]
        poses = arcs(samples, times)
        gap = np.full(len(samples), np.inf)
        # The horizon in parts: a sample that is not clear in one of them is not checked in the next.
        for part in np.split(poses, 4, axis=1):
            clear = gap >= PADDING_M
            gap[clear] = np.minimum(gap[clear], gaps(part[clear], points, corners, INFLATION_M).min(axis=1))
        end = poses[:, -1, :2]
        to_path, to_goal = nearest(end, path), nearest(end, path[-1:])
        near = np.clip(1.0 - gap / INFLATION_M, 0.0, 1.0)
        cost = PATH * to_path + GOAL * to_goal + OBSTACLE * near
        cost[gap < PADDING_M] = np.inf
        # No sample is clear: escape slowly backwards, as move_base's recovery does.
        return samples[cost.argmin()] if np.isfinite(cost.min()) else (max(-0.1, limits["min_vel_x"]), 0.0)

    return decide


serve("DWA on points", make)
