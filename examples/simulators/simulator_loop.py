"""Connects a simulator in Python to inbye (a line of JSON in, a line of JSON out), and the grid of static obstacles as boxes."""
import json
import sys

import numpy as np


def serve(name, make):
    """Runs a simulator until inbye ends it.

    `make(first)` gets the first message and returns a function. That gets a time (s) and a velocity (m/s, rad/s), and returns
    the state after that time.
    """
    step = None
    for line in sys.stdin:
        message = json.loads(line)
        if message["type"] == "simulate":
            step = make(message)
            answer = {"protocol": 1, "name": name}
        else:
            state = step(message["period_s"], message["linear"], message["angular"])
            answer = {"step": message["step"], **state}  # inbye checks that the answer is for this step
        print(json.dumps(answer), flush=True)


def occupied_cells(grid):
    """The occupied cells as an array of booleans, [row, column], with a border of occupied cells: all outside is occupied."""
    values = np.arange(len(grid["runs"])) % 2 == 1
    cells = np.repeat(values, grid["runs"]).reshape(grid["height"], grid["width"])
    return np.pad(cells, 1, constant_values=True)


def coarser(cells, ratio):
    """The cells in blocks of `ratio` by `ratio`; a block with an occupied cell is occupied. The border stays one cell wide."""
    inner = cells[1:-1, 1:-1]
    filled = np.pad(inner, [(0, -size % ratio) for size in inner.shape], constant_values=True)
    rows, columns = filled.shape[0] // ratio, filled.shape[1] // ratio
    return np.pad(filled.reshape(rows, ratio, columns, ratio).any(axis=(1, 3)), 1, constant_values=True)


def wall_boxes(cells, size_m, origin):
    """Boxes [centre x, centre y, half length, half width] that cover occupied cells with a border, map frame, in m.

    Runs of a row that repeat in the next rows are one box. Boxes that touch no free cell are left out: nothing reaches them.
    The lengths are along the grid, whose yaw is that of the origin.
    """
    boxes = min((_merged_runs(cells), _merged_runs(cells.T)[:, [2, 3, 0, 1]]), key=len)
    free = np.pad(np.cumsum(np.cumsum(~cells, axis=0), axis=1), ((1, 0), (1, 0)))
    low, high = np.maximum(boxes[:, [0, 2]] - 1, 0), np.minimum(boxes[:, [1, 3]] + 1, cells.shape)
    near = free[high[:, 0], high[:, 1]] - free[low[:, 0], high[:, 1]] - free[high[:, 0], low[:, 1]] + free[low[:, 0], low[:, 1]]
    top, bottom, left, right = boxes[near > 0].T
    # The border moves the first cell to row and column 1.
    across, along = ((left + right) / 2 - 1) * size_m, ((top + bottom) / 2 - 1) * size_m
    x, y, yaw = origin
    centers = [x + np.cos(yaw) * across - np.sin(yaw) * along, y + np.sin(yaw) * across + np.cos(yaw) * along]
    return np.column_stack([*centers, (right - left) * size_m / 2, (bottom - top) * size_m / 2])


def _merged_runs(cells):
    """Boxes [first row, row after the last, first column, column after the last]."""
    boxes, started = [], {}
    for row, change in enumerate(np.diff(np.pad(cells, ((0, 1), (1, 1))).astype(np.int8), axis=1)):
        runs = set(zip(np.flatnonzero(change == 1).tolist(), np.flatnonzero(change == -1).tolist()))
        for run in started.keys() - runs:
            boxes.append([started.pop(run), row, *run])
        for run in runs - started.keys():
            started[run] = row
    return np.array(sorted(boxes))


class Odometry:
    """Dead reckoning by encoders and a gyro, with constant errors drawn from a generator and white noise.

    The sizes of the errors are inbye's own (`OdometryNoise`): 0.5 % of the travel; 1 % of the turn, 0.02 deg/s and 0.05 deg/s
    of noise of each sample, from the datasheet of the MPU-6050.
    """

    def __init__(self, start, random):
        self.pose, self.twist, self.random = np.array(start, dtype=float), [0.0, 0.0], random
        self.travel_scale, self.gyro_scale = 1 + 0.005 * random.normal(), 1 + 0.01 * random.normal()
        self.gyro_bias_rad_s = 3.5e-4 * random.normal()

    def sample(self, travel_m, turned_rad, time_s):
        """Adds the travel by the encoders and the true rotation of a time."""
        rate = self.gyro_scale * turned_rad / time_s + self.gyro_bias_rad_s + 8.7e-4 * self.random.normal()
        travel, middle = travel_m * self.travel_scale, self.pose[2] + rate * time_s / 2
        self.pose += [travel * np.cos(middle), travel * np.sin(middle), rate * time_s]
        self.twist = [float(travel / time_s), float(rate)]

    def message(self):
        return {"pose": self.pose.tolist(), "twist": self.twist}


def scan_message(lidar, ranges_m, random):
    """The scan of true ranges, one for each angle of `beam_angles`, with noise; infinite where nothing is."""
    noisy = np.maximum(ranges_m + lidar["range_sigma_m"] * random.normal(size=len(ranges_m)), 0.0)
    ranges = np.minimum(np.where(ranges_m < lidar["range_max_m"], noisy, np.inf), lidar["range_max_m"])
    first, *_ = beam_angles(lidar)
    increment = lidar["field_of_view_rad"] / lidar["beams"]
    return {"angle_min": first, "angle_increment": increment, "range_max": lidar["range_max_m"], "ranges": ranges.tolist()}


def beam_angles(lidar):
    """Angles of the beams from the robot's x axis, rad."""
    return -lidar["field_of_view_rad"] / 2 + np.arange(lidar["beams"]) * lidar["field_of_view_rad"] / lidar["beams"]
