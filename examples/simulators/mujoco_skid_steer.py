"""A four-wheel skid-steer robot in MuJoCo: wheels with friction that slip in turns, and contact forces at the walls.

    pip install mujoco numpy
    inbye bench barn --worlds barn --simulator "python3 mujoco_skid_steer.py"

The robot is Clearpath's Jackal, scaled to the track width of the message: 17 kg, wheels of 0.098 m radius, 0.262 m from
axle to axle (`jackal.urdf.xacro`). Its body for contacts is the footprint of the message. Lidar in the middle of the body.
`--friction MU` (default 0.5, that of the wheels in `jackal.urdf.xacro`) and `--width-ratio RATIO` (default 1.5, the
`wheel_separation_multiplier` of Jackal's base controller) change the ground and the calibration of the base.

Not modelled: torque limits and delay of the motors, suspension, uneven ground, the time that a scan takes, lidar errors
other than noise of the range. Wheels touch only the floor, the body touches only walls.
"""
import argparse

import mujoco
import numpy as np
from simulator_loop import Odometry, beam_angles, occupied_cells, scan_message, serve, wall_boxes

TIME_STEP_S = 0.001
SAMPLE_STEPS = 10  # for a sample of the odometry: 100 Hz, as common base firmware
JACKAL_TRACK_M, WHEEL_RADIUS_M, WHEEL_WIDTH_M, WHEELBASE_M = 0.376, 0.098, 0.04, 0.262
MASS_KG, WHEEL_MASS_KG = 17.0, 0.477
WALL_HEIGHT_M, LIDAR_HEIGHT_RADII = 1.0, 2.5  # the beams are above the wheels
WHEELS = ["front_left", "rear_left", "front_right", "rear_right"]
# A tyre that yields 2 mm under Jackal's weight, and the inertia of a rotor behind its gear (kg m^2). With hard tyres and light
# wheels MuJoCo's convex friction lifts wheels that slip, and the robot turns at half the rate. With these values it turns on
# the spot with 1.51 times the track width at 0.5 rad/s, 1.56 at 1.57 rad/s; Coulomb friction gives 1 + (0.262/0.376)^2 = 1.49.
TYRE, ROTOR_INERTIA = 'solref="0.05 1" solimp="0.2 0.2 0.01"', 0.02
# Gain of a wheel's speed controller, Nm per rad/s: turning on the spot takes about 1 Nm, so the error is below 0.03 rad/s.
SPEED_GAIN = 50.0
# A wheel touches the floor and the body touches the walls, and nothing else.
FLOOR, WALL = 'contype="1" conaffinity="0"', 'contype="2" conaffinity="0"'
WHEEL, BODY = 'contype="0" conaffinity="1"', 'contype="0" conaffinity="2"'


def body_geoms(robot, height_m):
    """The footprint as a prism, or its discs as cylinders; and the mesh of the prism."""
    half, middle = height_m / 2, height_m / 4
    if robot["footprint"] is None:
        geoms = [f'<geom type="cylinder" pos="{disc["x"]} {disc["y"]} {middle}" size="{disc["radius"]} {half}" {BODY} mass="0"/>'
                 for disc in robot["discs"]]
        return "".join(geoms), ""
    corners = np.array(robot["footprint"])
    low, high = corners.min(axis=0), corners.max(axis=0)
    if len(corners) == 4 and all(np.isin(corners[:, axis], [low[axis], high[axis]]).all() for axis in (0, 1)):
        (x, y), (length, width) = (low + high) / 2, (high - low) / 2
        return f'<geom type="box" pos="{x} {y} {middle}" size="{length} {width} {half}" {BODY} mass="0"/>', ""
    vertices = " ".join(f"{x} {y} {z}" for x, y in corners for z in (middle - half, middle + half))
    return f'<geom type="mesh" mesh="body" {BODY} mass="0"/>', f'<asset><mesh name="body" vertex="{vertices}"/></asset>'


def model_xml(first, friction):
    scale = first["track_width_m"] / JACKAL_TRACK_M
    radius, mass = WHEEL_RADIUS_M * scale, MASS_KG * scale**3
    chassis_mass, wheel_mass = mass - 4 * WHEEL_MASS_KG * scale**3, WHEEL_MASS_KG * scale**3
    # The inertia of a homogeneous box of 0.42 by 0.31 by 0.18 m, Jackal's chassis, centred 0.03 m above the axles.
    length, width, height = 0.42 * scale, 0.31 * scale, 0.18 * scale
    inertia = chassis_mass / 12 * np.array([width**2 + height**2, length**2 + height**2, length**2 + width**2])
    grid = first["obstacles"]
    boxes, yaw = wall_boxes(occupied_cells(grid), grid["resolution_m"], grid["origin"]), grid["origin"][2]
    walls = "".join(f'<geom type="box" pos="{x} {y} {WALL_HEIGHT_M / 2}" size="{dx} {dy} {WALL_HEIGHT_M / 2}" '
                    f'euler="0 0 {yaw}" {WALL}/>' for x, y, dx, dy in boxes)
    wheels = "".join(
        f'<body pos="{x * WHEELBASE_M / 2 * scale} {y * first["track_width_m"] / 2} 0">'
        f'<joint name="{name}" axis="0 1 0" armature="{ROTOR_INERTIA * scale**5}"/>'
        f'<geom type="cylinder" euler="{np.pi / 2} 0 0" size="{radius} {WHEEL_WIDTH_M / 2 * scale}" mass="{wheel_mass}" '
        f'friction="{friction} 0.005 0.0001" {TYRE} {WHEEL}/></body>'
        for name, x, y in zip(WHEELS, (1, -1, 1, -1), (1, 1, -1, -1)))
    motors = "".join(f'<velocity joint="{name}" kv="{SPEED_GAIN * scale**5}"/>' for name in WHEELS)
    x, y, start_yaw = first["start"]
    body, asset = body_geoms(first["robot"], 0.2 * scale)
    return f"""<mujoco><compiler angle="radian" autolimits="true"/>
      <option timestep="{TIME_STEP_S}" integrator="implicitfast" cone="elliptic"/>{asset}
      <worldbody><geom name="floor" type="plane" size="0 0 1" friction="0 0 0" {FLOOR}/>{walls}
        <body name="robot" pos="{x} {y} {radius}" euler="0 0 {start_yaw}"><freejoint/>
          <inertial pos="0 0 {0.03 * scale}" mass="{chassis_mass}" diaginertia="{' '.join(map(str, inertia))}"/>
          {body}{wheels}</body></worldbody>
      <actuator>{motors}</actuator></mujoco>"""


def make(first):
    scale, lidar = first["track_width_m"] / JACKAL_TRACK_M, first["lidar"]
    radius_m, width_m = WHEEL_RADIUS_M * scale, first["track_width_m"] * options.width_ratio
    model = mujoco.MjModel.from_xml_string(model_xml(first, options.friction))
    data, random = mujoco.MjData(model), np.random.default_rng(first["seed"])
    odometry, robot = Odometry(first["start"], random), model.body("robot").id
    angles, distances = beam_angles(lidar), np.zeros(lidar["beams"])
    beams, hits = np.column_stack([np.cos(angles), np.sin(angles), 0 * angles]), np.zeros(lidar["beams"], dtype=np.int32)
    mujoco.mj_forward(model, data)

    def touches():
        floor = model.geom("floor").id
        return any(contact.geom1 != floor and contact.geom2 != floor for contact in data.contact)

    def scan():
        turn = data.xmat[robot].reshape(3, 3)
        origin = data.xpos[robot] + turn @ [0, 0, (LIDAR_HEIGHT_RADII - 1) * radius_m]
        # `robot` leaves out the body; the wheels are bodies of their own, but too low for the beams.
        mujoco.mj_multiRay(model, data, origin, (beams @ turn.T).ravel(), None, 1, robot, hits, distances, None,
                           lidar["beams"], lidar["range_max_m"])
        return scan_message(lidar, np.where(distances < 0, np.inf, distances), random)

    def step(period_s, linear, angular):
        speeds = np.array([linear - angular * width_m / 2, linear + angular * width_m / 2]) / radius_m
        data.ctrl[:] = speeds[[0, 0, 1, 1]]
        touched, turned_rad, steps, wheels = False, 0.0, 0, data.qpos[7:].mean()
        for _ in range(round(period_s / TIME_STEP_S)):
            mujoco.mj_step(model, data)
            touched = touched or touches()
            turned_rad, steps = turned_rad + data.qvel[5] * TIME_STEP_S, steps + 1
            if steps == SAMPLE_STEPS:
                odometry.sample((data.qpos[7:].mean() - wheels) * radius_m, turned_rad, steps * TIME_STEP_S)
                turned_rad, steps, wheels = 0.0, 0, data.qpos[7:].mean()
        mujoco.mj_forward(model, data)
        touched = touched or touches()
        turn = data.xmat[robot].reshape(3, 3)
        yaw = float(np.arctan2(turn[1, 0], turn[0, 0]))
        forward = float(np.cos(yaw) * data.qvel[0] + np.sin(yaw) * data.qvel[1])
        truth = {"pose": [*data.qpos[:2].tolist(), yaw], "twist": [forward, float(data.qvel[5])], "contact": touched}
        return {"odometry": odometry.message(), "scan": scan(), "truth": truth}

    return step


parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--friction", type=float, default=0.5)
parser.add_argument("--width-ratio", type=float, default=1.5)
options = parser.parse_args()
serve("mujoco_skid_steer", make)
