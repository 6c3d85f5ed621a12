// A controller in a shared library: it drives to the local target, and slows down for what the lidar sees ahead.
//
//   g++ -std=c++17 -shared -fPIC -I c/include c/examples/pursuit.cpp -o libpursuit.so
//   inbye drive --scene mine --controller "inbye-controller-host ./libpursuit.so"
#include <algorithm>
#include <cmath>

#include "inbye.h"

namespace {

class Pursuit {
public:
    explicit Pursuit(const InbyeRobot &robot) : robot(robot) {}

    // An exception of it brakes the robot; its text is the reason that inbye reports.
    bool compute_velocity(const InbyeControllerInput &input, double &linear, double &angular) const {
        double to_x = input.local_target[0] - input.pose[0], to_y = input.local_target[1] - input.pose[1];
        // At a goal with a yaw the robot turns to it. 0.15 m is within the usual tolerance, 0.25 m.
        double goal_m = std::hypot(input.goal[0] - input.pose[0], input.goal[1] - input.pose[1]);
        bool turns = input.has_goal_yaw && goal_m < 0.15;
        double heading = turns ? input.goal_yaw : std::atan2(to_y, to_x);
        double error = std::remainder(heading - input.pose[2], 2.0 * std::acos(-1.0));
        double ahead = input.range_max;
        for (size_t beam = 0; beam < input.range_count; ++beam) {
            double direction = input.angle_min + beam * input.angle_increment, range = input.ranges[beam];
            double x = input.lidar[0] + range * std::cos(direction), y = input.lidar[1] + range * std::sin(direction);
            double distance = std::hypot(x, y);
            if (std::fabs(std::atan2(y, x)) < 0.5 && distance < ahead) ahead = distance;  // NaN is not less
        }
        double fastest = std::min(robot.limits.max_vel_x, std::max(0.0, 0.6 * (ahead - robot.radius_m - 0.1)));
        linear = turns || std::fabs(error) > 0.5 ? 0.0 : fastest;
        angular = std::clamp(1.5 * error, -robot.limits.max_vel_theta, robot.limits.max_vel_theta);
        return true;
    }

private:
    InbyeRobot robot;
};

}  // namespace

INBYE_CONTROLLER(Pursuit)
