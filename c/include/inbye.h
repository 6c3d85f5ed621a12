/* The C interface of inbye: decisions, global paths and a navigator, and controllers in shared libraries.
 *
 * Metres, seconds and radians; x forward, y left, yaw counter-clockwise (REP-103). What a function returns as a pointer belongs to
 * the caller, who frees it with the function of its type. A function that fails returns NULL or false, and inbye_last_error() says
 * why. Objects may move between threads; only one thread at a time may use one, but any number of threads a map or a configuration.
 *
 * cbindgen makes this file of the sources in c/src. */

#ifndef INBYE_H
#define INBYE_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

/*
 Number of this interface. It changes when a program or a controller that was compiled for it must be compiled again.
 */
#define INBYE_ABI_VERSION 2

/*
 What the navigator does.
 */
typedef enum InbyeMode {
  INBYE_MODE_DRIVING,
  INBYE_MODE_ARRIVED,
  /*
   inbye_navigator_fault says why.
   */
  INBYE_MODE_FAILED,
  /*
   It brakes: the observation is faulty, and inbye_navigator_fault says why.
   */
  INBYE_MODE_SENSOR_FAULT,
} InbyeMode;

/*
 All settings of a robot and its navigation.
 */
typedef struct InbyeConfig InbyeConfig;

/*
 Evaluates samples on the CPU or on a GPU, with the same bits.
 */
typedef struct InbyeEngine InbyeEngine;

/*
 An occupancy grid with its zones. Unknown cells are obstacles, or free with `unknown = "free"` in the configuration.
 */
typedef struct InbyeMap InbyeMap;

/*
 Follows global paths to its goals among obstacles that are not in the map.
 */
typedef struct InbyeNavigator InbyeNavigator;

/*
 A pose: metres, and the yaw in radians, counter-clockwise.
 */
typedef struct InbyePose {
  double x;
  double y;
  double yaw;
} InbyePose;

/*
 A velocity: m/s forward, and rad/s counter-clockwise.
 */
typedef struct InbyeTwist {
  double linear;
  double angular;
} InbyeTwist;

/*
 A point in the map frame, metres.
 */
typedef struct InbyePoint {
  double x;
  double y;
} InbyePoint;

/*
 A moving obstacle in the map frame: centre and radius in metres, velocity in m/s.
 */
typedef struct InbyeMovingDisc {
  double x;
  double y;
  double radius;
  double vx;
  double vy;
} InbyeMovingDisc;

/*
 The inputs of one decision.
 */
typedef struct InbyeProblem {
  struct InbyePose pose;
  /*
   Measured velocity.
   */
  struct InbyeTwist velocity;
  /*
   The command of the last tick.
   */
  struct InbyeTwist last_command;
  /*
   The robot faces it at the end of the horizon. Its distance to the robot is limited, to 32 to 64 m
   depending on the resolution of the map: 51 m at 0.05 m.
   */
  struct InbyePoint target;
  /*
   The key node: the trajectory ends near it. Its distance to the robot has the same limit.
   */
  struct InbyePoint key_node;
  /*
   Moving obstacles, and their number.
   */
  const struct InbyeMovingDisc *obstacles;
  size_t obstacle_count;
} InbyeProblem;

/*
 The answer to one problem.
 */
typedef struct InbyeDecision {
  /*
   Whether a sample is admissible. If not, the robot must stop.
   */
  bool has_command;
  /*
   Velocity of the best sample, and its index.
   */
  struct InbyeTwist command;
  uint32_t index;
  /*
   Numbers of samples.
   */
  uint32_t admissible;
  uint32_t collision;
  uint32_t cannot_stop;
  uint32_t outside;
  /*
   SHA-256 of the exact bits of all samples, 64 hexadecimal digits and a zero, as `inbye evaluate` prints it. Only
   inbye_decide_with_digest computes it; from inbye_decide it is empty.
   */
  char digest[65];
} InbyeDecision;

/*
 A goal, with a yaw or without.
 */
typedef struct InbyeGoal {
  struct InbyePoint position;
  bool has_yaw;
  double yaw;
} InbyeGoal;

/*
 What the robot measures at a tick. All times are of one clock, seconds; that of the tick never goes back.
 */
typedef struct InbyeObservation {
  double time_s;
  /*
   Pose in the map, and the time of the measurement that corrected it last.
   */
  struct InbyePose pose;
  double pose_s;
  /*
   Velocity by odometry, and its time.
   */
  struct InbyeTwist velocity;
  double odometry_s;
  /*
   Ranges of the lidar in metres: infinite for nothing within range, NaN for no measurement.
   */
  const double *ranges;
  size_t range_count;
  /*
   Direction of the first beam in the robot's frame, angle between beams, both in radians, and the longest range. The last two are
   above zero. For a lidar that is mounted upside down, reverse the ranges: its last beam is then the first.
   */
  double angle_min;
  double angle_increment;
  double range_max;
  /*
   Time of the scan; unchanged where there is no newer one.
   */
  double scan_s;
  /*
   Place of the lidar in the robot's frame, metres: the ranges are from there.
   */
  struct InbyePoint lidar;
} InbyeObservation;

/*
 The decision of a tick.
 */
typedef struct InbyeCommand {
  /*
   The velocity to send to the base.
   */
  struct InbyeTwist velocity;
  enum InbyeMode mode;
  /*
   The key node that the robot drives to.
   */
  struct InbyePoint local_target;
} InbyeCommand;

/*
 How far a navigator is.
 */
typedef struct InbyeProgress {
  /*
   Length of the path ahead, to the last goal, metres.
   */
  double distance_left_m;
  /*
   Number of goals that the robot has left behind.
   */
  size_t goals_passed;
  /*
   Number of paths planned so far: a larger number means that the path is a new one.
   */
  size_t plans;
} InbyeProgress;

/*
 Limits of the robot, m/s, rad/s, m/s^2 and rad/s^2. Decelerations are below zero.
 */
typedef struct InbyeLimits {
  double min_vel_x;
  double max_vel_x;
  double max_vel_theta;
  double acc_lim_x;
  double decel_lim_x;
  double acc_lim_theta;
  double decel_lim_theta;
} InbyeLimits;

/*
 The robot that a controller is made for.
 */
typedef struct InbyeRobot {
  /*
   Control period, seconds.
   */
  double period_s;
  /*
   Radius around the robot's origin that contains its body, metres.
   */
  double radius_m;
  struct InbyeLimits limits;
} InbyeRobot;

/*
 What a controller decides from at a tick. Poses are x, y and yaw in the map frame; velocities m/s and rad/s. The arrays are
 valid during the call.
 */
typedef struct InbyeControllerInput {
  double time_s;
  double pose[3];
  double velocity[2];
  /*
   Pose and velocity when a command of this tick takes effect.
   */
  double predicted_pose[3];
  double predicted_velocity[2];
  double last_command[2];
  /*
   Limits as far as the drive has shown them.
   */
  struct InbyeLimits limits;
  double goal[2];
  bool has_goal_yaw;
  double goal_yaw;
  /*
   The key node that inbye would drive to.
   */
  double local_target[2];
  /*
   The global path: x and y of each point, and their number.
   */
  const double *path;
  size_t path_count;
  /*
   Length of the path behind the robot, metres.
   */
  double path_progress_m;
  /*
   Whether another goal begins with this tick.
   */
  bool is_reset;
  /*
   Ranges of the newest scan, metres: NaN for no measurement, the longest range for nothing within it.
   */
  const double *ranges;
  size_t range_count;
  double angle_min;
  double angle_increment;
  double range_max;
  double scan_s;
  /*
   Tracked moving obstacles: x, y, radius, vx and vy of each, and their number.
   */
  const double *moving_obstacles;
  size_t moving_obstacle_count;
  /*
   Place of the lidar in the robot's frame, metres: the ranges are from there.
   */
  double lidar[2];
} InbyeControllerInput;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/*
 Returns INBYE_ABI_VERSION of the loaded library.
 */
uint32_t inbye_abi_version(void);

/*
 Opens an engine: "auto", the fastest for decisions of the default size, "cpu", "gpu" or "gpu:NAME", with up to 1024 threads of the
 CPU; 0 counts as 1. Returns null on failure.

 Precondition: `name` points to a text that ends with zero.
 */
struct InbyeEngine *inbye_engine_open(const char *name,
                                      size_t threads);

/*
 Frees an engine.

 Precondition: `engine` is null or an engine that was not freed.
 */
void inbye_engine_free(struct InbyeEngine *engine);

/*
 Takes one decision. Limits, footprint and samples are those of the configuration. Where zones of the map limit the speed, the
 limits are lower, as a navigator has them there; a robot that is faster brakes.

 Precondition: `engine`, `map` and `config` are alive; `problem` can be read, and so can its obstacles; `decision` can be written.
 */
bool inbye_decide(struct InbyeEngine *engine,
                  const struct InbyeMap *map,
                  const struct InbyeConfig *config,
                  const struct InbyeProblem *problem,
                  struct InbyeDecision *decision);

/*
 As inbye_decide, with the digest of all samples, which takes longer.

 Precondition: As for inbye_decide.
 */
bool inbye_decide_with_digest(struct InbyeEngine *engine,
                              const struct InbyeMap *map,
                              const struct InbyeConfig *config,
                              const struct InbyeProblem *problem,
                              struct InbyeDecision *decision);

/*
 Returns the message of the last failure in this thread, UTF-8; empty if there was none. It stays valid until the next
 failure in this thread.
 */
const char *inbye_last_error(void);

/*
 Makes a map of width times height cells, the lowest row first. A cell has its occupancy, 0 to 100 percent, or -1 if it is
 unknown: a nav_msgs/OccupancyGrid. The resolution is the side of a cell in metres, the origin the pose of the lower left
 corner. A map has at most 32,767 cells along each side and 100,000,000 in all. Returns null on failure.

 Precondition: `cells` points to width times height values.
 */
struct InbyeMap *inbye_map_new(const int8_t *cells,
                               int32_t width,
                               int32_t height,
                               double resolution_m,
                               struct InbyePose origin);

/*
 Reads a map_server YAML file, a MovingAI map or rows of text. The side of a cell, metres, counts for the last two. Returns
 null on failure.

 Precondition: `path` points to a text that ends with zero.
 */
struct InbyeMap *inbye_map_load(const char *path,
                                double resolution_m);

/*
 Makes a copy of a map with zones in which the robot must not drive, or only slowly. The masks are those of Nav2's costmap filters:
 occupied cells of `keepout` are closed, and a value of 30 in `speed` limits the speed to 70 percent of the largest. They may have
 another size and resolution than the map; null for none. Zones that the map has already are kept: of two limits the lower counts. A
 lidar sees through zones. Returns null on failure.

 Precondition: `map` is alive; `keepout` and `speed` are null or maps that are alive.
 */
struct InbyeMap *inbye_map_with_zones(const struct InbyeMap *map,
                                      const struct InbyeMap *keepout,
                                      const struct InbyeMap *speed);

/*
 Frees a map. Navigators made of it stay valid.

 Precondition: `map` is null or a map that was not freed.
 */
void inbye_map_free(struct InbyeMap *map);

/*
 Makes the default settings with the changes of a text, TOML with the keys of a configuration file; null for no changes.
 Returns null on failure.

 Precondition: `toml` is null or points to a text that ends with zero.
 */
struct InbyeConfig *inbye_config_new(const char *toml);

/*
 Frees a configuration.

 Precondition: `config` is null or a configuration that was not freed.
 */
void inbye_config_free(struct InbyeConfig *config);

/*
 Plans a path from a start to a goal: a smooth one, or that of the program `global_planner.command` of the configuration. Writes up
 to `capacity` points into `points`, and the number of all of them into `count`: where it is larger than the capacity, call again
 with more room.

 Precondition: `map` and `config` are alive; `points` has room for `capacity` points; `count` can be written.
 */
bool inbye_plan(const struct InbyeMap *map,
                const struct InbyeConfig *config,
                struct InbyePoint start,
                struct InbyePoint goal,
                struct InbyePoint *points,
                size_t capacity,
                size_t *count);

/*
 Makes a navigator that drives to all goals in turn, and plans a path to each. Its engine is one thread of the CPU. It has no
 protective layer below it: a program that drives a real base must have its own, which stops the robot before what the lidar sees
 and when commands stay away. Returns null on failure.

 Precondition: `map` and `config` are alive, `goals` points to this many goals.
 */
struct InbyeNavigator *inbye_navigator_new(const struct InbyeMap *map,
                                           const struct InbyeConfig *config,
                                           struct InbyePoint start,
                                           const struct InbyeGoal *goals,
                                           size_t goal_count);

/*
 Frees a navigator.

 Precondition: `navigator` is null or a navigator that was not freed.
 */
void inbye_navigator_free(struct InbyeNavigator *navigator);

/*
 Decides what to do now. Call it every `local.control_period_s` of the configuration, 0.1 s by default. A measurement that is not
 finite is a faulty observation: the robot brakes.

 On a real robot set `navigator.wait_for_plans = false`; otherwise a step can take as long as a plan. By default a step waits for a
 plan that is due, so that a simulation is the same at each repetition.

 Precondition: `navigator` is alive; `observation` can be read, and so can its ranges; `command` can be written.
 */
bool inbye_navigator_step(struct InbyeNavigator *navigator,
                          const struct InbyeObservation *observation,
                          struct InbyeCommand *command);

/*
 Returns why the mission failed, or what is wrong with the last observation; empty where both are sound. It stays valid until the
 next step.

 Precondition: `navigator` is alive.
 */
const char *inbye_navigator_fault(const struct InbyeNavigator *navigator);

/*
 Limits the speed from the next step on, m/s; infinite for no limit. A robot that is faster brakes. With a limit of zero it stands
 or turns on the spot, and this time does not count as time without progress. Limits of zones count too.

 Precondition: `navigator` is alive.
 */
bool inbye_navigator_set_speed_limit(struct InbyeNavigator *navigator,
                                     double limit_m_s);

/*
 Replaces the goals while the robot drives, or after it arrived or failed: plans a path to each of them on the present map, and the
 next step drives to the first. `start` is where the robot is. What the scans showed is kept. The call takes as long as the plans: on
 a large map stop the robot before, with a speed limit of zero. On failure the goals so far remain.

 Precondition: `navigator` is alive; `goals` has `goal_count` goals.
 */
bool inbye_navigator_set_goals(struct InbyeNavigator *navigator,
                               struct InbyePoint start,
                               const struct InbyeGoal *goals,
                               size_t goal_count);

/*
 Replaces the map, in the same frame, while the robot drives: the next step avoids its obstacles and zones, and a path on it is
 planned at once. Obstacles that only the lidar saw remain. Where the map has no path even without them, the mission fails within
 a second by the default settings. It takes time in proportion to the map's area.

 Precondition: `navigator` and `map` are alive.
 */
bool inbye_navigator_set_map(struct InbyeNavigator *navigator,
                             const struct InbyeMap *map);

/*
 Returns how far the robot is.

 Precondition: `navigator` is alive; `progress` can be written.
 */
bool inbye_navigator_progress(const struct InbyeNavigator *navigator, struct InbyeProgress *progress);

/*
 Writes up to `capacity` points of the path that the robot follows into `points`, and the number of all of them into `count`.

 Precondition: `navigator` is alive; `points` has room for `capacity` points; `count` can be written.
 */
bool inbye_navigator_path(const struct InbyeNavigator *navigator,
                          struct InbyePoint *points,
                          size_t capacity,
                          size_t *count);

/* A controller in a shared library has the following functions. `inbye-controller-host LIBRARY` calls them, as in
 *   inbye drive --scene mine --controller "inbye-controller-host ./libmy_controller.so"
 *
 * The library runs in a process of its own. What it prints to the standard output goes to the standard error output. In C++,
 * INBYE_CONTROLLER defines all of them for a class. */

/* Makes a function visible outside a library, also where it is compiled with -fvisibility=hidden. */
#if defined(_WIN32)
#define INBYE_EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define INBYE_EXPORT __attribute__((visibility("default")))
#else
#define INBYE_EXPORT
#endif

/* Write INBYE_CONTROLLER_ABI once in a library, outside all functions: the host refuses a library of another version. */
#ifdef __cplusplus
#define INBYE_CONTROLLER_ABI \
    extern "C" uint32_t inbye_controller_abi_version() { return INBYE_ABI_VERSION; }
#else
#define INBYE_CONTROLLER_ABI \
    uint32_t inbye_controller_abi_version(void) { return INBYE_ABI_VERSION; }
#endif

/* INBYE_CONTROLLER_ABI defines it. */
INBYE_EXPORT uint32_t inbye_controller_abi_version(void);

/* Makes a controller for a robot. Null is a failure. No C++ exception may leave this or another function. */
INBYE_EXPORT void *inbye_controller_create(const struct InbyeRobot *robot);

/* Writes speed (m/s) and turn rate (rad/s) of this tick. Returns false where there is no valid velocity: the robot brakes. A value
 * that is not finite ends the mission. */
INBYE_EXPORT bool inbye_controller_compute_velocity(void *controller, const struct InbyeControllerInput *input,
                                                    double *linear, double *angular);

/* Optional: returns why the last call of inbye_controller_create returned null, or that of inbye_controller_compute_velocity false;
 * null for no reason. The text is UTF-8, and stays valid until the next call of a function. */
INBYE_EXPORT const char *inbye_controller_error(void);

/* Frees a controller. */
INBYE_EXPORT void inbye_controller_destroy(void *controller);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#ifdef __cplusplus
#include <exception>
#include <string>

namespace inbye_controller {

inline std::string &reason() {
    static std::string text;
    return text;
}

template <typename Result, typename Call>
Result guarded(Result failed, Call call) noexcept {
    reason().clear();
    try {
        return call();
    } catch (const std::exception &error) {
        reason() = error.what();
    } catch (...) {
        reason() = "an exception that is no std::exception";
    }
    return failed;
}

}  // namespace inbye_controller

/* Defines all functions of a controller, once in a library and outside all namespaces, for a class with a constructor and a method:
 *   Class(const InbyeRobot &robot);
 *   bool compute_velocity(const InbyeControllerInput &input, double &linear, double &angular);
 * An exception of the constructor is a failure. One of the method counts as false. The text of what() is the reason. */
#define INBYE_CONTROLLER(Class) \
    INBYE_CONTROLLER_ABI \
    extern "C" void *inbye_controller_create(const InbyeRobot *robot) { \
        return inbye_controller::guarded<void *>(nullptr, [=]() -> void * { return new Class(*robot); }); \
    } \
    extern "C" bool inbye_controller_compute_velocity(void *controller, const InbyeControllerInput *input, double *linear, \
                                                      double *angular) { \
        return inbye_controller::guarded(false, [=]() -> bool { \
            return static_cast<Class *>(controller)->compute_velocity(*input, *linear, *angular); \
        }); \
    } \
    extern "C" const char *inbye_controller_error() { \
        return inbye_controller::reason().empty() ? nullptr : inbye_controller::reason().c_str(); \
    } \
    extern "C" void inbye_controller_destroy(void *controller) { delete static_cast<Class *>(controller); }
#endif

#endif  /* INBYE_H */
