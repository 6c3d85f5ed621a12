// Takes a decision, plans a path and steps a navigator from C++, as a Nav2 controller plugin would.
//
//   g++ -std=c++17 -I c/include c/examples/decide.cpp -L target/release -l inbye_c -o decide
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

#include "inbye.h"

namespace {

template <auto function>
struct Free {
    template <typename Object>
    void operator()(Object *object) const { function(object); }
};
using Map = std::unique_ptr<InbyeMap, Free<inbye_map_free>>;
using Config = std::unique_ptr<InbyeConfig, Free<inbye_config_free>>;
using Engine = std::unique_ptr<InbyeEngine, Free<inbye_engine_free>>;
using Navigator = std::unique_ptr<InbyeNavigator, Free<inbye_navigator_free>>;

void require(bool is_done) {
    if (!is_done) {
        std::fprintf(stderr, "%s\n", inbye_last_error());
        std::exit(1);
    }
}

}  // namespace

int main() {
    require(inbye_abi_version() == INBYE_ABI_VERSION);
    // A room of 8 m by 4 m with walls, as a nav_msgs/OccupancyGrid has it.
    constexpr int width = 80, height = 40;
    std::vector<int8_t> cells(width * height, 0);
    for (int row = 0; row < height; ++row) {
        for (int column = 0; column < width; ++column) {
            bool is_wall = row == 0 || row == height - 1 || column == 0 || column == width - 1;
            cells[row * width + column] = is_wall ? 100 : 0;
        }
    }
    Map map(inbye_map_new(cells.data(), width, height, 0.1, {0.0, 0.0, 0.0}));
    require(map != nullptr);
    Config config(inbye_config_new("robot.footprint = [{ x = 0.0, y = 0.0, radius = 0.3 }]\n"
                                   "local = { vx_samples = 16, vtheta_samples = 64 }\n"));
    require(config != nullptr);

    Engine engine(inbye_engine_open("cpu", 1));
    require(engine != nullptr);
    InbyeMovingDisc person{6.0, 3.0, 0.3, -0.3, 0.0};
    InbyeProblem problem{};
    problem.pose = {1.5, 2.0, 0.0};
    problem.velocity = problem.last_command = {0.4, 0.0};
    problem.target = problem.key_node = {6.0, 2.0};
    problem.obstacles = &person;
    problem.obstacle_count = 1;
    InbyeDecision decision;
    require(inbye_decide_with_digest(engine.get(), map.get(), config.get(), &problem, &decision));
    require(decision.has_command);
    std::printf("command %.3f m/s, %+.3f rad/s\n", decision.command.linear, decision.command.angular);
    std::printf("digest %s\n", decision.digest);
    // Without the digest a decision takes less time.
    InbyeDecision same;
    require(inbye_decide(engine.get(), map.get(), config.get(), &problem, &same));
    bool is_same = same.index == decision.index && same.admissible == decision.admissible && same.digest[0] == '\0';

    // Unknown cells ahead are obstacles, or free with this setting.
    std::vector<int8_t> unseen = cells;
    for (int row = 1; row < height - 1; ++row) { unseen[row * width + 21] = -1; }
    Map unknown(inbye_map_new(unseen.data(), width, height, 0.1, {0.0, 0.0, 0.0}));
    Config free_unknown(inbye_config_new("unknown = \"free\"\n"
                                         "robot.footprint = [{ x = 0.0, y = 0.0, radius = 0.3 }]\n"
                                         "local = { vx_samples = 16, vtheta_samples = 64 }\n"));
    require(free_unknown != nullptr);
    InbyeDecision blocked, open;
    require(inbye_decide(engine.get(), unknown.get(), config.get(), &problem, &blocked));
    require(inbye_decide(engine.get(), unknown.get(), free_unknown.get(), &problem, &open));
    bool is_open = blocked.admissible < decision.admissible && open.admissible == decision.admissible;
    std::printf("unknown cells %s\n", is_open ? "follow the setting" : "do not follow the setting");

    size_t count = 0;
    std::vector<InbyePoint> path(100);
    require(inbye_plan(map.get(), config.get(), {1.5, 2.0}, {6.0, 2.5}, path.data(), path.size(), &count));
    std::printf("path of %zu points\n", count);

    // The robot drives without error, and sees only the walls. This is a simulation, so its steps may wait for plans. For a real robot
    // set navigator.wait_for_plans = false.
    InbyeGoal goal{{6.0, 2.5}, false, 0.0};
    Navigator navigator(inbye_navigator_new(map.get(), config.get(), {1.5, 2.0}, &goal, 1));
    require(navigator != nullptr);
    map.reset();
    // A zone will close the straight way.
    std::vector<int8_t> mask(width * height, 0);
    for (int row = 0; row < 28; ++row) {
        for (int column = 35; column < 45; ++column) { mask[row * width + column] = 100; }
    }
    Map room(inbye_map_new(cells.data(), width, height, 0.1, {0.0, 0.0, 0.0}));
    Map keepout(inbye_map_new(mask.data(), width, height, 0.1, {0.0, 0.0, 0.0}));
    Map zoned(inbye_map_with_zones(room.get(), keepout.get(), nullptr));
    require(zoned != nullptr);
    auto is_kept = [&] {
        bool is_outside = count <= path.size();
        for (size_t index = 0; is_outside && index < count; ++index) {
            is_outside = path[index].x < 3.5 || path[index].x > 4.5 || path[index].y > 2.8;
        }
        return is_outside;
    };
    InbyeProgress progress;
    double fastest = 0.0;
    double x = 1.5, y = 2.0, yaw = 0.0;
    InbyeCommand command{};
    std::vector<double> ranges(360);
    for (int tick = 0; tick < 600 && command.mode != INBYE_MODE_ARRIVED; ++tick) {
        const double pi = std::acos(-1.0);
        for (int beam = 0; beam < 360; ++beam) {
            double direction = yaw - pi + beam * pi / 180.0, cosine = std::cos(direction), sine = std::sin(direction);
            double across = (cosine > 0.0 ? 7.9 - x : x - 0.1) / std::fmax(std::fabs(cosine), 1e-9);
            double along = (sine > 0.0 ? 3.9 - y : y - 0.1) / std::fmax(std::fabs(sine), 1e-9);
            ranges[beam] = std::fmin(across, along);
        }
        double now = 0.1 * tick;
        if (tick == 5) {
            require(inbye_navigator_set_speed_limit(navigator.get(), 0.2));
            require(inbye_navigator_set_map(navigator.get(), zoned.get()));
        }
        InbyeObservation seen{};
        seen.time_s = seen.pose_s = seen.odometry_s = seen.scan_s = now;
        seen.pose = {x, y, yaw};
        seen.velocity = command.velocity;
        seen.ranges = ranges.data();
        seen.range_count = ranges.size();
        seen.angle_min = -pi;
        seen.angle_increment = pi / 180.0;
        seen.range_max = 20.0;
        require(inbye_navigator_step(navigator.get(), &seen, &command));
        if (tick > 20) { fastest = std::fmax(fastest, command.velocity.linear); }
        x += 0.1 * command.velocity.linear * std::cos(yaw);
        y += 0.1 * command.velocity.linear * std::sin(yaw);
        yaw += 0.1 * command.velocity.angular;
    }
    std::printf("%s at (%.2f, %.2f)\n", command.mode == INBYE_MODE_ARRIVED ? "arrived" : inbye_navigator_fault(navigator.get()), x, y);
    require(inbye_navigator_progress(navigator.get(), &progress));
    require(inbye_navigator_path(navigator.get(), path.data(), path.size(), &count));
    bool has_obeyed = fastest <= 0.2 && progress.plans > 1 && progress.goals_passed == 0 && is_kept();
    std::printf("%zu paths, %.2f m left, at most %.2f m/s\n", progress.plans, progress.distance_left_m, fastest);
    require(inbye_plan(zoned.get(), config.get(), {1.5, 2.0}, {6.0, 2.5}, path.data(), path.size(), &count));
    has_obeyed = has_obeyed && is_kept();
    std::printf("the paths %s the closed zone\n", is_kept() ? "avoid" : "enter");

    // Another goal for the same navigator.
    InbyeGoal back{{1.5, 2.0}, false, 0.0};
    require(inbye_navigator_set_goals(navigator.get(), {x, y}, &back, 1));
    require(inbye_navigator_progress(navigator.get(), &progress));
    std::printf("%.1f m back\n", progress.distance_left_m);

    // An error says what is wrong.
    Config wrong(inbye_config_new("[local]\nvx_sample = 16\n"));
    std::printf("error: %s\n", inbye_last_error());
    return wrong == nullptr && is_same && is_open && has_obeyed && command.mode == INBYE_MODE_ARRIVED ? 0 : 1;
}
