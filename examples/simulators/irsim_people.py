"""A robot among people in ir-sim: its own 2-D world, lidar and differential drive, and people by ORCA.

    pip install ir-sim pyrvo
    inbye drive --map mine.yaml --start 10,5 --goal 80,40 --simulator "python3 irsim_people.py --people 8"

The people are discs of 0.25 m radius that walk at 0.6 to 1.4 m/s to random goals. They avoid each other, the walls and the
robot by ORCA (van den Berg, Guy, Lin and Manocha 2011), the library `pyrvo` that ir-sim uses too: each of them expects the
robot to do half of the avoidance. The seed decides their starts, at least `--clear` metres (default 3) from the robot's
start, their speeds, and their goals, which they reach on a straight line of free cells.

The robot follows each command within its limits of acceleration. Its pose in the map has an error of 0.01 m and 0.005 rad.

Not modelled: slip and delay of the robot, legs, people that stop or do not yield, the time that a scan takes.
"""
import argparse
import contextlib
import json
import sys
import tempfile

import numpy as np
import pyrvo
import shapely
from scipy.ndimage import distance_transform_edt
from simulator_loop import Odometry, coarser, occupied_cells, serve, wall_boxes

with contextlib.redirect_stdout(sys.stderr):  # it prints which window systems are missing
    import irsim

BLOCK_M = 0.2  # resolution of the walls for people
STEP_S = 0.05  # longest step of the world; contacts are judged at each
PERSON_RADIUS_M, SPEEDS_M_S = 0.25, (0.6, 1.4)
NEIGHBOR_DISTANCE_M, NEIGHBORS, HORIZON_S, WALL_HORIZON_S = 6.0, 10, 3.0, 1.0
ARRIVED_M, PATIENCE_S = 0.3, 8.0  # a person takes another goal when it is there, or after this time without 0.5 m of progress


def in_map(points, origin):
    """Points of the grid, m from its corner, in the map frame."""
    x, y, yaw = origin
    return np.asarray(points) @ [[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]] + [x, y]


def corners_of(boxes):
    """The corners of each box, counter-clockwise."""
    x, y, dx, dy = boxes.T
    return np.stack([[x - dx, y - dy], [x + dx, y - dy], [x + dx, y + dy], [x - dx, y + dy]]).transpose(2, 0, 1)


class FreeSpace:
    """Walls in blocks of 0.2 m as people take them, and the blocks that are far enough from them."""

    def __init__(self, grid):
        ratio = max(round(BLOCK_M / grid["resolution_m"]), 1)
        self.size, self.origin = ratio * grid["resolution_m"], grid["origin"]
        self.occupied = coarser(occupied_cells(grid), ratio)
        self.free = distance_transform_edt(~self.occupied)[1:-1, 1:-1] * self.size > PERSON_RADIUS_M + self.size
        self.points = in_map((np.argwhere(self.free)[:, ::-1] + 0.5) * self.size, self.origin)

    def point(self, random):
        return self.points[random.integers(len(self.points))]

    def has_line(self, start, end):
        parts = np.linspace(0, 1, 2 + int(np.linalg.norm(end - start) / self.size))[:, None]
        # A person that was pushed to a wall stands on a block that is not free: the first 0.6 m do not count.
        x, y, yaw = self.origin
        from_corner = in_map(start + parts[3:] * (end - start) - [x, y], [0.0, 0.0, -yaw])
        columns, rows = np.floor(from_corner / self.size).astype(int).T
        return self.free[rows, columns].all()


class People:
    """People that plan by ORCA; agent 0 is the robot."""

    def __init__(self, first, count, random):
        self.random, self.space = random, FreeSpace(first["obstacles"])
        start, robot = np.array(first["start"][:2]), first["robot"]
        self.positions, self.speeds = np.empty((0, 2)), random.uniform(*SPEEDS_M_S, count)
        for _ in range(1000):
            place = self.space.point(random)
            away = np.linalg.norm(self.positions - place, axis=1).min(initial=np.inf)
            if len(self.positions) < count and away > 3 * PERSON_RADIUS_M and np.linalg.norm(place - start) > options.clear:
                self.positions = np.vstack([self.positions, place])
        self.goals = np.array([self.goal(place) for place in self.positions]).reshape(-1, 2)
        self.nearest_m, self.waited_s = np.full(len(self.goals), np.inf), np.zeros(len(self.goals))
        self.orca = pyrvo.RVOSimulator()
        radius_m = PERSON_RADIUS_M + 0.05
        self.orca.set_agent_defaults(NEIGHBOR_DISTANCE_M, NEIGHBORS, HORIZON_S, WALL_HORIZON_S, radius_m, SPEEDS_M_S[1])
        for position in [start, *self.positions]:
            self.orca.add_agent(position.tolist())
        self.orca.set_agent_radius(0, robot["radius_m"])
        for corners in corners_of(wall_boxes(self.space.occupied, self.space.size, [0.0, 0.0, 0.0])):
            self.orca.add_obstacle(in_map(corners, self.space.origin).tolist())
        self.orca.process_obstacles()

    def goal(self, place):
        for _ in range(100):
            goal = self.space.point(self.random)
            if np.linalg.norm(goal - place) > 2.0 and self.space.has_line(place, goal):
                return goal
        return place

    def velocities(self, robot, robot_velocity, positions, time_s):
        self.orca.set_time_step(time_s)
        self.orca.set_agent_position(0, robot.tolist())
        self.orca.set_agent_velocity(0, robot_velocity.tolist())
        self.orca.set_agent_pref_velocity(0, robot_velocity.tolist())
        for index, position in enumerate(positions):
            away = np.linalg.norm(self.goals[index] - position)
            self.waited_s[index] = 0.0 if away < self.nearest_m[index] - 0.5 else self.waited_s[index] + time_s
            self.nearest_m[index] = away if self.waited_s[index] == 0.0 else self.nearest_m[index]
            if away < ARRIVED_M or self.waited_s[index] > PATIENCE_S:
                self.goals[index], self.nearest_m[index], self.waited_s[index] = self.goal(position), np.inf, 0.0
            towards = self.goals[index] - position
            wanted = self.speeds[index] * towards / max(np.linalg.norm(towards), 0.1)
            self.orca.set_agent_position(index + 1, position.tolist())
            self.orca.set_agent_pref_velocity(index + 1, wanted.tolist())
        self.orca.do_step()
        return [list(self.orca.get_agent_velocity(index + 1).to_tuple()) for index in range(len(positions))]


def robot_yaml(first):
    robot, limits, lidar = first["robot"], first["robot"]["limits"], first["lidar"]
    discs = [{"name": "circle", "radius": disc["radius"], "pose": [disc["x"], disc["y"], 0]} for disc in robot["discs"]]
    shape = {"name": "polygon", "vertices": robot["footprint"]} if robot["footprint"] else {"name": "compound", "parts": discs}
    sensor = {"name": "lidar2d", "number": lidar["beams"], "angle_range": lidar["field_of_view_rad"],
              "range_max": lidar["range_max_m"], "noise": lidar["range_sigma_m"] > 0, "std": lidar["range_sigma_m"]}
    return {"kinematics": {"name": "diff"}, "shape": shape, "state": first["start"], "sensors": [sensor],
            "vel_min": [limits["min_vel_x"], -limits["max_vel_theta"]], "vel_max": [limits["max_vel_x"], limits["max_vel_theta"]],
            "acce": [-limits["decel_lim_x"], limits["acc_lim_theta"]]}


def add_walls(env, grid):
    """Adds the outline of the occupied cells. ir-sim's own, of each cell, has five times the points."""
    boxes = shapely.polygons(corners_of(wall_boxes(occupied_cells(grid), grid["resolution_m"], [0.0, 0.0, 0.0])))
    # Boxes that are turned would not meet exactly: their outline is turned.
    corners, line = shapely.get_coordinates(shapely.get_parts(shapely.union_all(boxes).boundary).tolist(), return_index=True)
    corners = in_map(corners, grid["origin"])
    ends = np.stack([corners[:-1], corners[1:]], axis=1)[line[:-1] == line[1:]]
    walls, = env.object_factory.create_from_map(corners[:1].T, np.array([[0.1], [0.1]]))
    walls.linestrings = list(shapely.linestrings(ends))
    walls.geometry_tree, walls._geometry = shapely.STRtree(walls.linestrings), shapely.multilinestrings(walls.linestrings)
    shapely.prepare(walls._geometry)
    env.add_objects([walls])


def make(first):
    grid, random = first["obstacles"], np.random.default_rng(first["seed"])
    people, odometry = People(first, options.people, random), Odometry(first["start"], random)
    step_s = first["period_s"] / np.ceil(first["period_s"] / STEP_S - 1e-9)
    persons = [{"kinematics": {"name": "omni"}, "shape": {"name": "circle", "radius": PERSON_RADIUS_M},
                "state": [*place.tolist(), 0], "vel_min": [-2, -2], "vel_max": [2, 2]} for place in people.positions]
    width, height = grid["width"] * grid["resolution_m"], grid["height"] * grid["resolution_m"]
    ends = in_map([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]], grid["origin"])
    (width, height), offset = np.ptp(ends, axis=0).tolist(), ends.min(axis=0).tolist()
    world = {"width": width, "height": height, "offset": offset, "step_time": step_s, "collision_mode": "unobstructed"}
    with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file:
        json.dump({"world": world, "robot": [robot_yaml(first)], "obstacle": persons}, file)
        file.flush()
        env = irsim.make(file.name, headless=True, log_level="ERROR", seed=first["seed"])
    add_walls(env, grid)
    robot, walkers = env.robot, env.obstacle_list[:len(persons)]
    lidar, robot.sensors = robot.lidar, []  # measures at the end of a period only

    def pose():
        return robot.state[:3, 0].astype(float)

    def step(period_s, linear, angular):
        touched = robot.collision
        for _ in range(round(period_s / step_s)):
            (x, y, yaw), (v, w) = pose(), robot.velocity[:2, 0]
            moves = people.velocities(np.array([x, y]), v * np.array([np.cos(yaw), np.sin(yaw)]),
                                      [walker.state[:2, 0] for walker in walkers], step_s)
            env.step([np.array([linear, angular]), *map(np.array, moves)], [robot.id, *(walker.id for walker in walkers)])
            odometry.sample(robot.velocity[0, 0] * step_s, robot.velocity[1, 0] * step_s, step_s)
            touched = touched or robot.collision
        lidar.step(robot.state[:3])
        scan = lidar.get_scan()
        message = {"angle_min": scan["angle_min"], "angle_increment": scan["angle_increment"], "range_max": scan["range_max"],
                   "ranges": np.where(scan["valid"], scan["ranges"], scan["range_max"]).tolist()}
        truth = {"pose": pose().tolist(), "twist": robot.velocity[:2, 0].astype(float).tolist(), "contact": bool(touched),
                 "moving": [[*walker.state[:2, 0].tolist(), PERSON_RADIUS_M] for walker in walkers]}
        measured = (pose() + random.normal(size=3) * [0.01, 0.01, 0.005]).tolist()
        return {"odometry": odometry.message(), "scan": message, "pose": measured, "truth": truth}

    return step


parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--people", type=int, default=4)
parser.add_argument("--clear", type=float, default=3.0)
options = parser.parse_args()
serve("irsim_people", make)
