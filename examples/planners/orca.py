"""Optimal reciprocal collision avoidance, van den Berg, Guy, Lin and Manocha 2011, by the wheel `pyrvo` that ir-sim uses."""
import numpy as np
import pyrvo
from controller_loop import in_robot_frame, path_ahead, scan_points, serve

HORIZON_S, NEAREST, STATIC_RADIUS_M = 2.0, 40, 0.03


def make(start):
    radius = start["robot"]["radius_m"] + 0.03

    def decide(tick):
        limits, (v, _), yaw = tick["limits"], tick["twist"], tick["pose"][2]
        fastest = limits["max_vel_x"]
        simulator = pyrvo.RVOSimulator()
        simulator.set_time_step(start["period_s"])
        simulator.set_agent_defaults(4.0, NEAREST, HORIZON_S, HORIZON_S, radius, fastest)
        robot = simulator.add_agent([0.0, 0.0])
        simulator.set_agent_velocity(robot, [v, 0.0])
        target = path_ahead(tick, 1.0)[-1]
        simulator.set_agent_pref_velocity(robot, (fastest * target / max(np.linalg.norm(target), 0.1)).tolist())
        moving = tick["moving_obstacles"]
        centers = in_robot_frame([[disc["x"], disc["y"]] for disc in moving], tick["pose"]) if moving else np.empty((0, 2))
        for disc, center in zip(moving, centers):
            agent = simulator.add_agent(center.tolist())
            simulator.set_agent_radius(agent, disc["radius"])
            turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
            simulator.set_agent_velocity(agent, (np.array([disc["vx"], disc["vy"]]) @ turn).tolist())
        points = scan_points(tick, 4.0)
        for point in points[np.argsort(np.linalg.norm(points, axis=1))][: NEAREST * 4 : 4]:
            simulator.set_agent_radius(simulator.add_agent(point.tolist()), STATIC_RADIUS_M)
        simulator.do_step()
        velocity = simulator.get_agent_velocity(robot)
        x, y = (velocity.x, velocity.y) if hasattr(velocity, "x") else velocity
        heading = np.arctan2(y, x) if np.hypot(x, y) > 0.02 else np.arctan2(target[1], target[0])
        # A tracked robot turns towards the velocity, and drives the part of it that lies ahead.
        speed = np.hypot(x, y) * max(0.0, np.cos(heading)) ** 3
        return speed, np.clip(2.0 * heading, -limits["max_vel_theta"], limits["max_vel_theta"])

    return decide


serve("ORCA", make, wants=["moving_obstacles"])
