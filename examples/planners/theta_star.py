"""A global planner: Theta* of the wheel `python-motion-planning` on the grid of inbye."""
import json
import sys

import numpy as np
from python_motion_planning.common import TYPES, Grid
from python_motion_planning.path_planner import ThetaStar
from scipy.ndimage import distance_transform_edt


def plan(message):
    grid = message["grid"]
    occupied = np.repeat(np.arange(len(grid["runs"])) % 2 == 1, grid["runs"]).reshape(grid["height"], grid["width"])
    cell_m, (x, y, _) = grid["resolution_m"], grid["origin"]
    free = distance_transform_edt(np.pad(~occupied, 1))[1:-1, 1:-1] * cell_m >= message["radius_m"]
    place = lambda point: (int((point[0] - x) / cell_m), int((point[1] - y) / cell_m))
    start, goal = place(message["start"]), place(message["goal"])
    map_ = Grid(bounds=[[0, grid["width"]], [0, grid["height"]]])
    map_.type_map[~free.T] = TYPES.OBSTACLE
    path, found = ThetaStar(map_=map_, start=start, goal=goal).plan()
    if not found["success"]:
        return {"error": "no path"}
    middle = [[x + (column + 0.5) * cell_m, y + (row + 0.5) * cell_m] for column, row in path]
    return {"path": [message["start"], *middle[1:-1], message["goal"]]}


for line in sys.stdin:
    message = json.loads(line)
    if message["type"] == "start":
        answer = {"protocol": 1, "name": "Theta*"}
    else:
        answer = {"request": message["request"], **plan(message)}
    print(json.dumps(answer), flush=True)
