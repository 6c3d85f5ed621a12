"""The dynamic window approach of the wheel `kompass-core`, with its defaults."""
import logging
from types import SimpleNamespace

import numpy as np
from controller_loop import scan_points, serve
from kompass_core.control import DWA, DWAConfig
from kompass_core.models import AngularCtrlLimits, LinearCtrlLimits, Robot, RobotCtrlLimits, RobotGeometry, RobotState, RobotType

logging.disable(logging.CRITICAL)


def make(start):
    limits, radius = start["robot"]["limits"], start["robot"]["radius_m"]
    shape = {"geometry_type": RobotGeometry.Type.CYLINDER, "geometry_params": np.array([radius, 0.4])}
    robot = Robot(robot_type=RobotType.DIFFERENTIAL_DRIVE, **shape)
    vx = LinearCtrlLimits(max_vel=limits["max_vel_x"], max_acc=limits["acc_lim_x"], max_decel=-limits["decel_lim_x"])
    omega = AngularCtrlLimits(max_omega=limits["max_vel_theta"], max_acc=limits["acc_lim_theta"], max_decel=-limits["decel_lim_theta"], max_ang=np.pi)
    controller = DWA(robot, RobotCtrlLimits(vx_limits=vx, omega_limits=omega), DWAConfig(control_time_step=start["period_s"]))
    known = [None]

    def decide(tick):
        if known[0] is not tick["path"]:
            known[0] = tick["path"]
            place = lambda point: SimpleNamespace(pose=SimpleNamespace(position=SimpleNamespace(x=point[0], y=point[1])))
            controller.set_path(SimpleNamespace(poses=[place(point) for point in tick["path"]]))
        points, (x, y, yaw), (v, w) = scan_points(tick), tick["pose"], tick["twist"]
        ranges, angles = np.hypot(*points.T), np.arctan2(*points.T[::-1])
        state = RobotState(x=x, y=y, yaw=yaw, speed=v, vx=v, omega=w)
        found = controller.loop_step(current_state=state, ranges=ranges, angles=angles)
        return (controller.linear_x_control[0], controller.angular_control[0]) if found else None

    return decide


serve("kompass-core DWA", make)
