/*
 * taut: shortens planners' paths and proves every answer collision-free.
 *
 * Every call that can fail gives a code: TAUT_SUCCESS, or what is wrong (TAUT_*, negative), and then, where its
 * last parameter is not NULL, an error there to be freed by taut_error_free. A null, freed or wrong handle gives
 * TAUT_MALFORMED_REQUEST; so does what can be seen of other mistakes. Strings are UTF-8 and end with a zero.
 * Lengths are metres, angles radians, times seconds, unless a name says otherwise.
 *
 * Any call may come from any thread, also on the same handle; two threads that wait for the answers of one request
 * take turns. A handle and what is read through it must not be freed by one thread while another reads through it.
 * Nothing throws, and a panic inside becomes TAUT_CRASH. After a fork only the parent may go on.
 *
 * Made by cbindgen from ipc/c/src; do not edit.
 */

#ifndef TAUT_H
#define TAUT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// `taut_next`: there are no more answers.
#define TAUT_END 0

// Done, or proved.
#define TAUT_SUCCESS 1

// `taut_next`: nothing came within the time; the request goes on.
#define TAUT_PENDING 2

// The path collides, or is outside a path constraint, between its ends.
#define TAUT_INVALID_MOTION_PLAN -2

// A watched path that was proved is no longer, after a change of its scene.
#define TAUT_MOTION_PLAN_INVALIDATED_BY_ENVIRONMENT_CHANGE -3

// The deadline passed before the path was proved.
#define TAUT_TIMED_OUT -6

// Cancelled.
#define TAUT_PREEMPTED -7

// The first waypoint collides.
#define TAUT_START_STATE_IN_COLLISION -10

// The first waypoint is outside a path constraint.
#define TAUT_START_STATE_VIOLATES_PATH_CONSTRAINTS -11

// The last waypoint collides.
#define TAUT_GOAL_IN_COLLISION -12

// The last waypoint is outside a path constraint.
#define TAUT_GOAL_VIOLATES_PATH_CONSTRAINTS -13

// Unknown group.
#define TAUT_INVALID_GROUP_NAME -15

// NaN, wrong or missing columns, not a unit quaternion, outside the limits.
#define TAUT_INVALID_ROBOT_STATE -17

// Unknown link.
#define TAUT_INVALID_LINK_NAME -18

// Unknown object.
#define TAUT_INVALID_OBJECT_NAME -19

// Something panicked; the message says what.
#define TAUT_CRASH -29

// Not provable, and nothing found colliding.
#define TAUT_UNCERTIFIED -1001

// The daemon has too much to do; `taut_error_retry_after_ms` says when to try again.
#define TAUT_OVERLOADED -1002

// This client has too many requests in flight.
#define TAUT_QUOTA -1003

// No robot of that label.
#define TAUT_UNKNOWN_ROBOT -1004

// No scene of that label.
#define TAUT_UNKNOWN_SCENE -1005

// The scene has another version.
#define TAUT_VERSION_CONFLICT -1006

// Too large, or no memory or disk left.
#define TAUT_RESOURCE_EXHAUSTED -1007

// A call that is wrong in itself: a null or freed handle, a bad option.
#define TAUT_MALFORMED_REQUEST -1008

// No daemon, or it went away; sending again is safe.
#define TAUT_DAEMON_LOST -1009

// The robot or scene is still being prepared.
#define TAUT_LOADING -1010

// The label names other content and replacing was not asked for.
#define TAUT_LABEL_TAKEN -1011

// A robot or scene file is wrong; the message names file and line.
#define TAUT_INVALID_MODEL -1012

// A robot or scene file cannot be read.
#define TAUT_UNREADABLE_FILE -1013

// A path constraint names what is not there, makes no sense or cannot be proved.
#define TAUT_INVALID_CONSTRAINT -1014

// The path is proved, but has no times; the message says why.
#define TAUT_UNTIMED -1015

// What is said of times makes no sense, or a joint that moves has no limit.
#define TAUT_INVALID_TIMING -1016

// What a sensor sees of the scene is older than the request allows.
#define TAUT_CLOUD_TOO_OLD -1017

// `taut_options.mode`: prove the path, change nothing.
#define TAUT_MODE_CHECK 0

// `taut_options.mode`: the gradient method.
#define TAUT_MODE_GRADIENT 1

// `taut_options.mode`: shortcuts between random configurations.
#define TAUT_MODE_RANDOM_SHORTCUT 2

// `taut_options.mode`: shortcuts of single joints.
#define TAUT_MODE_PARTIAL_SHORTCUT 3

// `taut_options.mode`: the gradient method with contact half-spaces.
#define TAUT_MODE_CONTACT 4

// `taut_options.mode`: shortcuts and contact half-spaces in turns, by what they gain.
#define TAUT_MODE_HYBRID 5

// Kind of what a path must keep: the distance of two bodies, at least the floor. Below 0 they
// overlap: the penetration depth, from below unless both are convex.
#define TAUT_KIND_CLEARANCE 0

// What is left of how far something may turn; below 0 it is outside by so much.
#define TAUT_KIND_ORIENTATION 1

// What is left of where a point may be; below 0 it is outside by so much.
#define TAUT_KIND_POSITION 2

// What is left of where a joint may be; below 0 it is outside by so much.
#define TAUT_KIND_JOINT 3

// Unit of amounts and floors: metres.
#define TAUT_UNIT_METRE 0

// Unit of amounts and floors: radians.
#define TAUT_UNIT_RADIAN 1

// `taut_trajectory.controller`: cubics that have the positions and velocities of both points.
#define TAUT_CONTROLLER_CUBIC 0

// `taut_trajectory.controller`: quintics that have their accelerations too.
#define TAUT_CONTROLLER_QUINTIC 1

// `taut_trajectory.controller`: straight ways, `rate_hz` points per second.
#define TAUT_CONTROLLER_LINEAR 2

// `taut_trajectory.stage`: it stops at every waypoint.
#define TAUT_TIMING_STOPS 0

// `taut_trajectory.stage`: it rounds corners.
#define TAUT_TIMING_ROUNDED 1

// `taut_trajectory.stage`: parts of it are shortcuts in time.
#define TAUT_TIMING_SHORTCUTS 2

// One answer, in shared memory. Freed by `taut_answer_free`; it outlives its request and its
// connection.
typedef struct taut_answer taut_answer;

// A request in flight: the stream of its answers. Freed, and so cancelled, by `taut_answers_free`.
typedef struct taut_answers taut_answers;

// A connection to a daemon. One per process is enough: every call on it may come from any thread,
// and four requests can be in flight. It survives a restart of the daemon.
typedef struct taut_daemon taut_daemon;

// Why a call failed: a code, a line for people, and, where a path is at fault, what it does not keep
// and where.
// Made by calls that take a `taut_error **`; freed by `taut_error_free`.
typedef struct taut_error taut_error;

// A robot's variables, as they were when asked for. Freed by `taut_robot_free`.
typedef struct taut_robot taut_robot;

// Where a path does not keep what it must, or is not proved to.
typedef struct {
    // What is not kept is about these: of a clearance the two bodies. One that is empty is no name.
    // Valid until the error is freed.
    const char *names[2];
    // What kind of thing it is, TAUT_KIND_*; newer versions have more kinds.
    uint32_t kind;
    // What `amount` and `allowed` are counted in, TAUT_UNIT_*.
    uint32_t unit;
    // Segment of the path, from 0.
    uint32_t segment;
    // 0; keeps what follows aligned.
    uint32_t reserved;
    // Ratio on the segment, 0 to 1.
    double t;
    // How much is kept there.
    double amount;
    // The floor: how much must be kept.
    double allowed;
    // Where that is seen, world frame, in metres: of a clearance a point on each body.
    double points[2][3];
    // Unit vector along which the first point moves for more to be kept: of a clearance from the
    // second body to the first.
    double normal[3];
} taut_place;

// Files of a robot. Set `size` to sizeof(taut_robot_files), all that is not needed to 0.
typedef struct {
    // sizeof(taut_robot_files).
    size_t size;
    // The URDF file.
    const char *urdf;
    // The SRDF file; NULL = none. Without it links joined by one joint may touch, nothing else.
    const char *srdf;
    // Names of packages that the URDF's meshes name as package://NAME/.
    const char *const *package_names;
    // The folder of each.
    const char *const *package_folders;
    // How many.
    size_t package_count;
} taut_robot_files;

// One variable of a robot.
typedef struct {
    // Its name, as columns are named; valid until the robot is freed.
    const char *name;
    // Lowest value (rad or m); -infinity = none.
    double lower;
    // Highest value; infinity = none.
    double upper;
    // Whether it is an angle on the circle.
    bool continuous;
} taut_variable;

// A version of a scene.
typedef struct {
    // Its number.
    uint64_t version;
    // Hash of its content.
    uint64_t hash;
    // Objects in it.
    uint32_t objects;
    // 0.
    uint32_t reserved;
} taut_scene_info;

// Where something stands.
typedef struct {
    // x y z, in metres.
    double position[3];
    // Unit quaternion x y z w.
    double orientation[4];
} taut_pose;

// Options of a request; `taut_options_default` fills them in. Arrays and strings are read during
// the call that they are given to, and not kept. `docs/options.md` has them in other languages.
typedef struct {
    // sizeof(taut_options).
    size_t size;
    // Time that the request may take, from when it is sent; the best path by then is the answer,
    // in seconds; 0 = no limit.
    double deadline_s;
    // Distance that every pair of bodies must keep, in metres; 0 = 1mm.
    double clearance_m;
    // Most work to spend on a shorter path, in the units of the answer's `work`: the same on every
    // machine; 0 = 200,000,000.
    uint64_t work_budget;
    // Seed of every random choice.
    uint64_t seed;
    // Version of the scene, of those that are kept; 0 = the newest.
    uint64_t scene_version;
    // Refuse where what a sensor sees of the scene is older than this, in seconds; 0 = any age.
    double max_age_s;
    // Optimizer, one of TAUT_MODE_*.
    uint32_t mode;
    // Class of the request: one of a higher class is served first.
    uint32_t priority;
    // Refuse a path that keeps less, instead of lowering the clearance of the pairs that come
    // closer: 0 or 1.
    uint8_t strict;
    // Take the columns of continuous joints as they stand, as real numbers and not as angles on
    // the circle: 0 or 1.
    uint8_t unwrapped;
    // Do not look for what is nearest along the path; without it the answer comes sooner: 0 or 1.
    uint8_t without_contacts;
    // Mode check only: tell again when a change of the scene makes the path unsafe or safe, until
    // the request is dropped: 0 or 1.
    uint8_t watch;
    // Keep the goal's numbers: refuse a path whose angles lead there only by a step of more than
    // half a turn, and take no path that ends whole turns away: 0 or 1.
    uint8_t keep_goal;
    // Prove each segment at the largest clearance that it keeps, up to 10 cm, and tell how far
    // what is executed may stray from the path: 0 or 1.
    uint8_t corridor;
    // 0; keeps what follows aligned.
    uint8_t reserved[2];
    // Names of the path's columns, in the path's order; joints of the robot that are missing stand
    // still; NULL = all of the robot's, in its order.
    const char *const *columns;
    // How many.
    size_t column_count;
    // Where a joint stands that is no column of the path, instead of at 0: names, and a number for
    // each; 0 of them = 0.
    const char *const *held_names;
    // The number of each.
    const double *held_values;
    // How many.
    size_t held_count;
    // Weights of the metric, one per velocity coordinate of the robot; NULL = metres of reach.
    const double *weights;
    // How many.
    size_t weight_count;
    // Weight of a joint in the metric, by its name, instead of the one that it has: names, and a
    // number for each; 0 of them = the metric's.
    const char *const *joint_weight_names;
    // The number of each.
    const double *joint_weights;
    // How many.
    size_t joint_weight_count;
    // Waypoints that stay as they are to the last bit, counted from 0; the ends always do; NULL =
    // the ends.
    const size_t *fixed_waypoints;
    // How many.
    size_t fixed_count;
    // Group of the robot: only its joints may move otherwise than on the path given; NULL = all
    // may.
    const char *group;
    // What the path must keep besides clearance, see docs/constraints.md: MoveIt's Constraints in
    // JSON, a list of such, or few words such as "upright hand:x=0.1"; NULL = nothing.
    const char *constraints;
    // A trajectory along the path, near the least time that the motors allow and proved as it is
    // written, see docs/timing.md: what they allow, and how it is executed. MoveIt's
    // joint_limits.yaml, with our words beside it, or few words such as "acceleration=2/s
    // speed=0.5"; NULL = no times.
    const char *timing;
} taut_options;

// Figures of an answer.
typedef struct {
    // Length of the path that was sent, in the request's metric.
    double length_before;
    // Length of this path.
    double length_after;
    // No path between the same ends is shorter.
    double lower_bound;
    // The distance that is proved for every pair without a floor of its own, in metres.
    double clearance_m;
    // The lowest floor of any clearance, in metres.
    double floor_m;
    // Version of the scene that it is proved against; 0 where none is kept.
    uint64_t scene_version;
    // Hash of that scene's content.
    uint64_t scene_hash;
    // Hash of the robot's content.
    uint64_t robot_hash;
    // Iterations of the method.
    uint64_t iterations;
    // Counted work.
    uint64_t work;
    // Time that the request waited, in nanoseconds.
    uint64_t queue_ns;
    // Time that it was worked on, in nanoseconds.
    uint64_t compute_ns;
    // Waypoints.
    size_t waypoints;
    // Columns, as many as the request had.
    size_t columns;
    // Counts the answers of a request from 0; a gap means that newer ones took the place of some.
    uint32_t sequence;
    // Whether the path is proved.
    bool proved;
    // Whether it is the last.
    bool is_final;
    // Whether the scene has a newer version by now.
    bool superseded;
    // Pairs of bodies that were checked; 0 of a final answer: there is nothing to check.
    uint64_t pairs;
    // Age of the oldest frame among those that the scene is seen by, when the answer was sent, in
    // nanoseconds; 0 = no sensor sees it.
    uint64_t world_age_ns;
} taut_info;

// A path in shared memory: number `column` of waypoint `i` is `first[i * stride + column]`.
typedef struct {
    // The first number.
    const double *first;
    // How many rows.
    size_t waypoints;
    // Numbers of a row, in the order of the request's columns.
    size_t columns;
    // Numbers from one row to the next.
    size_t stride;
} taut_rows;

// What a person should know beside a verdict.
typedef struct {
    // One line; valid until the answer is freed.
    const char *text;
    // Whether it says what the verdict does not cover, or rests on; else it takes nothing from the
    // verdict.
    bool uncovered;
} taut_warning;

// What a proved path keeps of one constraint, of its tolerance as it is asked.
typedef struct {
    // What messages call it; valid until the answer is freed.
    const char *name;
    // What kind of thing it is, TAUT_KIND_*; newer versions have more kinds.
    uint32_t kind;
    // What the numbers are counted in, TAUT_UNIT_*.
    uint32_t unit;
    // The tolerance, where one number says it: then what is read of the path, such as an angle, is
    // proved to be asked - left at most. Else 0.
    double asked;
    // What is proved to be left everywhere along the path; below 0 where the tolerance is raised and
    // that is needed.
    double left;
    // The least that was found to be left: a look, no proof.
    double found;
    // Where on the segment that was found, 0 to 1.
    double t;
    // The segment, from 0.
    uint32_t segment;
    // 0; keeps what follows aligned.
    uint32_t reserved;
} taut_kept;

// How far what is executed may stray from a proved path: around every configuration p of a
// segment, every q with the sum of reach x |q - p| at most the segment's slack keeps the floor.
typedef struct {
    // Distance that every pair keeps within the corridor, in metres.
    double floor_m;
    // How far bodies move at most against each other, per unit of each velocity coordinate of the
    // robot (m per rad or m); valid until the answer is freed.
    const double *reach;
    // How many.
    size_t reach_count;
    // Slack of each segment, in metres; valid until the answer is freed.
    const double *slack_m;
    // How many.
    size_t slack_count;
} taut_corridor;

// When what is to be where: proved as it is written, at every instant. Tables have a row for each point,
// in the request's columns; what it points to is valid until the answer is freed.
typedef struct {
    // When each point is passed, in nanoseconds from the start, where the first one is.
    const int64_t *times_ns;
    // How many.
    size_t points;
    // Numbers of a row.
    size_t columns;
    // Positions (rad or m).
    const double *positions;
    // Velocities (per s); NULL where the controller goes straight.
    const double *velocities;
    // Accelerations (per s^2); NULL where a controller that had them would go another way.
    const double *accelerations;
    // For each column the least and greatest velocity, the least and greatest acceleration it was allowed.
    const double *limits;
    // For each column the largest part of a limit of velocity that is used and when (s), the same of
    // acceleration.
    const double *used;
    // From the first point to the last, in seconds.
    double duration_s;
    // No trajectory between the same ends within the same limits takes less, in seconds.
    double bound_s;
    // What the first trajectory that was proved takes, which stops where it must, in seconds.
    double stops_s;
    // Clearance that is proved at every instant, in metres; infinite where nothing is near.
    double clearance_m;
    // Points per second of TAUT_CONTROLLER_LINEAR; else 0.
    double rate_hz;
    // What goes from point to point, TAUT_CONTROLLER_*.
    uint32_t controller;
    // What it comes of, TAUT_TIMING_*.
    uint32_t stage;
    // Work that it took.
    uint64_t work;
    // The column whose motor needs the time of the bound; `columns` where it is none of the request's.
    size_t decides;
    // Where it comes nearest to anything: the two bodies; NULL where nothing was found or looked for.
    const char *nearest_names[2];
    // When, in seconds.
    double nearest_time_s;
    // Their distance, in metres.
    double nearest_m;
    // The closest points, in the world, in metres.
    double nearest_points[2][3];
} taut_trajectory;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// The name of a code, such as "TIMED_OUT"; "UNKNOWN" for a number that is none. Valid for ever.
const char *taut_code_name(int32_t code);

// The code of an error; TAUT_SUCCESS for NULL, TAUT_MALFORMED_REQUEST for one that is freed.
int32_t taut_error_code(const taut_error *error);

// What happened, in one line: the bad value, the valid ones and the next step. Valid until the
// error is freed.
const char *taut_error_message(const taut_error *error);

// When the same call may succeed, in milliseconds; 0 = never.
uint32_t taut_error_retry_after_ms(const taut_error *error);

// Where on the path, if that is what is wrong: true and `*place` filled in, or false. `size` is
// sizeof *place.
//
// # Safety
// `place` points to `size` bytes, or is NULL.
bool taut_error_place(const taut_error *error, taut_place *place, size_t size);

// Frees an error and its texts. NULL and errors that are freed are let be.
void taut_error_free(taut_error *error);

// Connects to a daemon. `instance` is NAME or NAME:ROOT; NULL = what the variable TAUT_INSTANCE
// says, or the default. Closed by `taut_close`.
//
// Codes: TAUT_DAEMON_LOST if there is none, TAUT_OVERLOADED if it is full.
//
// # Safety
// `instance` is NULL or a string; `daemon` points to a place for the handle, `error` too or is
// NULL.
int32_t taut_connect(const char *instance, taut_daemon **daemon, taut_error **error);

// Closes a connection. Requests and answers that were made with it stay until they are freed. NULL
// and connections that are closed are let be.
void taut_close(taut_daemon *daemon);

// Loads a robot under a label; with `replace`, even if the label names another one. `robot` may be
// NULL.
//
// Codes: TAUT_INVALID_MODEL, TAUT_UNREADABLE_FILE, TAUT_LABEL_TAKEN.
//
// # Safety
// Strings and arrays are what `taut_robot_files` says; `robot` and `error` are NULL or places for
// handles.
int32_t taut_load_robot(const taut_daemon *daemon,
                        const char *label,
                        const taut_robot_files *files,
                        bool replace,
                        taut_robot **robot,
                        taut_error **error);

// Variables of a robot that is loaded.
//
// Codes: TAUT_UNKNOWN_ROBOT; the message has the labels that are loaded.
//
// # Safety
// `label` is a string; `robot` and `error` are NULL or places for handles.
int32_t taut_describe_robot(const taut_daemon *daemon,
                            const char *label,
                            taut_robot **robot,
                            taut_error **error);

// How many variables a robot has; 0 for one that is freed.
size_t taut_robot_variables(const taut_robot *robot);

// One variable, in the robot's order: true and `*variable` filled in, or false for an index beyond
// the last.
//
// # Safety
// `variable` points to a `taut_variable`, or is NULL.
bool taut_robot_variable(const taut_robot *robot, size_t index, taut_variable *variable);

// Frees a description; the robot stays loaded. NULL and descriptions that are freed are let be.
void taut_robot_free(taut_robot *robot);

// Loads a scene (JSON text, as scene files are) under a label; with `replace`, even if the label
// names another one. Mesh files in it start from `folder`, which may be NULL. `info` may be NULL;
// `size` is sizeof *info.
//
// # Safety
// Strings are strings; places are NULL or the caller's, `info` of `size` bytes.
int32_t taut_load_scene(const taut_daemon *daemon,
                        const char *label,
                        const char *json,
                        const char *folder,
                        bool replace,
                        taut_scene_info *info,
                        size_t size,
                        taut_error **error);

// Makes the changes of a diff (JSON with "is_diff": true), all or none: the scene's next version.
// The scene has to have the version `base`; 0 = any.
//
// Codes: TAUT_VERSION_CONFLICT, TAUT_INVALID_OBJECT_NAME, TAUT_INVALID_LINK_NAME.
//
// # Safety
// As `taut_load_scene`.
int32_t taut_change_scene(const taut_daemon *daemon,
                          const char *label,
                          const char *json,
                          const char *folder,
                          uint64_t base,
                          taut_scene_info *info,
                          size_t size,
                          taut_error **error);

// Moves an object of the world, or, with a `link`, one that the link carries, `pose` then being in
// the link's frame.
//
// # Safety
// As `taut_load_scene`; `link` is NULL or a string, `pose` points to a pose.
int32_t taut_move_object(const taut_daemon *daemon,
                         const char *label,
                         const char *object,
                         const char *link,
                         const taut_pose *pose,
                         taut_scene_info *info,
                         size_t size,
                         taut_error **error);

// Lets a link carry an object of the world, its pose in the link's frame. It may touch the link
// and the `touch_links`.
//
// # Safety
// As `taut_move_object`; `touch_links` are `touch_count` strings.
int32_t taut_attach_object(const taut_daemon *daemon,
                           const char *label,
                           const char *object,
                           const char *link,
                           const taut_pose *pose,
                           const char *const *touch_links,
                           size_t touch_count,
                           taut_scene_info *info,
                           size_t size,
                           taut_error **error);

// Puts an attached object down, its pose in the world.
//
// # Safety
// As `taut_move_object`.
int32_t taut_detach_object(const taut_daemon *daemon,
                           const char *label,
                           const char *object,
                           const taut_pose *pose,
                           taut_scene_info *info,
                           size_t size,
                           taut_error **error);

// Takes an object out of the world.
//
// # Safety
// As `taut_load_scene`.
int32_t taut_remove_object(const taut_daemon *daemon,
                           const char *label,
                           const char *object,
                           taut_scene_info *info,
                           size_t size,
                           taut_error **error);

// Fills in options with what a request means that says nothing more. `size` is sizeof *options.
//
// # Safety
// `options` points to `size` bytes, or is NULL.
void taut_options_default(taut_options *options, size_t size);

// Figures of an answer. `size` is sizeof *info.
//
// # Safety
// `info` points to `size` bytes; `error` is NULL or a place for a handle.
int32_t taut_answer_info(const taut_answer *answer, taut_info *info, size_t size, taut_error **error);

// Shows an answer's path where it lies, in shared memory: read-only, valid until the answer is
// freed. `size` is sizeof *rows.
//
// TAUT_INVALID_ROBOT_STATE if the request's columns are not a stretch of the robot's variables in
// its order: then `taut_answer_copy` puts them in the request's order.
//
// # Safety
// `rows` points to `size` bytes; `error` is NULL or a place for a handle.
int32_t taut_answer_rows(const taut_answer *answer, taut_rows *rows, size_t size, taut_error **error);

// Copies an answer's path, row by row, in the request's columns, into the `capacity` numbers at
// `numbers`. It has `waypoints` x `columns` of them (`taut_answer_info`).
//
// # Safety
// `numbers` points to `capacity` numbers; `error` is NULL or a place for a handle.
int32_t taut_answer_copy(const taut_answer *answer, double *numbers, size_t capacity, taut_error **error);

// How many warnings come with an answer, first those that say what the verdict does not cover; 0
// for one that is freed.
size_t taut_answer_warnings(const taut_answer *answer);

// One warning of an answer: true and `*warning` filled in, or false for an index beyond the last.
//
// # Safety
// `warning` points to a `taut_warning`, or is NULL.
bool taut_answer_warning(const taut_answer *answer, size_t index, taut_warning *warning);

// Of how many constraints a final answer tells what it keeps: all that the request had, where the
// path is proved; 0 for one that is freed.
size_t taut_answer_keeps(const taut_answer *answer);

// What an answer keeps of one constraint: true and `*kept` filled in, or false for an index beyond the
// last. `size` is sizeof *kept.
//
// # Safety
// `kept` points to `size` bytes, or is NULL.
bool taut_answer_kept(const taut_answer *answer, size_t index, taut_kept *kept, size_t size);

// The corridor of a final answer whose request had `corridor`: true and `*corridor` filled in, or
// false where there is none. `size` is sizeof *corridor.
//
// # Safety
// `corridor` points to `size` bytes, or is NULL.
bool taut_answer_corridor(const taut_answer *answer, taut_corridor *corridor, size_t size);

// The trajectory of an answer whose request had `timing`; on the way, the one so far. `size` is
// sizeof *trajectory.
//
// TAUT_UNTIMED where there is none, with why: the deadline came first, none is proved, or none was asked
// for. The path is there all the same.
//
// # Safety
// `trajectory` points to `size` bytes; `error` is NULL or a place for a handle.
int32_t taut_answer_trajectory(const taut_answer *answer,
                               taut_trajectory *trajectory,
                               size_t size,
                               taut_error **error);

// Frees an answer; its memory goes back. NULL and answers that are freed are let be.
void taut_answer_free(taut_answer *answer);

// Sends a path to be shortened. `path` is `waypoints` rows of `columns` numbers (rad, m, unit
// quaternions), which are copied into shared memory once. `scene` may be NULL: nothing around the
// robot. `options` may be NULL.
//
// Codes, before anything is sent: TAUT_UNKNOWN_ROBOT, TAUT_UNKNOWN_SCENE, TAUT_INVALID_ROBOT_STATE
// for columns, TAUT_INVALID_GROUP_NAME, TAUT_QUOTA, TAUT_RESOURCE_EXHAUSTED, TAUT_DAEMON_LOST.
//
// # Safety
// Strings are strings, `path` has so many numbers, `options` is NULL or filled in; `answers` and
// `error` are places for handles, `error` may be NULL.
int32_t taut_shorten(const taut_daemon *daemon,
                     const char *robot,
                     const char *scene,
                     const double *path,
                     size_t waypoints,
                     size_t columns,
                     const taut_options *options,
                     taut_answers **answers,
                     taut_error **error);

// Proves a path as it is, and waits for the verdict: TAUT_SUCCESS if it is proved, otherwise the
// code of what is wrong with it, with what is not kept and where in the error. The options' mode is not
// looked at. `info` may be NULL; `size` is sizeof *info.
//
// # Safety
// As `taut_shorten`; `info` is NULL or `size` bytes.
int32_t taut_check(const taut_daemon *daemon,
                   const char *robot,
                   const char *scene,
                   const double *path,
                   size_t waypoints,
                   size_t columns,
                   const taut_options *options,
                   taut_info *info,
                   size_t size,
                   taut_error **error);

// The next answer: each is shorter than the one before and proved, the last is final. Waits at
// most `timeout_s` seconds (infinity is allowed).
//
// Codes: TAUT_SUCCESS with `*answer`; TAUT_PENDING if nothing came in time (call again); TAUT_END
// after the final one; what the daemon says against the path, with what is not kept and where;
// TAUT_PREEMPTED after `taut_cancel`; TAUT_DAEMON_LOST within 100 ms of the daemon's death;
// TAUT_QUOTA if two answers of this request are not freed.
//
// # Safety
// `answer` is a place for a handle, `error` too or NULL.
int32_t taut_next(const taut_answers *answers, double timeout_s, taut_answer **answer, taut_error **error);

// The final answer; those before it are skipped. Codes as `taut_next`, the timeout is for all of
// it.
//
// # Safety
// As `taut_next`.
int32_t taut_result(const taut_answers *answers, double timeout_s, taut_answer **answer, taut_error **error);

// Asks for the best so far, now: the final answer comes soon. May come from any thread.
//
// # Safety
// `error` is NULL or a place for a handle.
int32_t taut_finish_early(const taut_answers *answers, taut_error **error);

// Cancels a request: a thread that waits for it gets TAUT_PREEMPTED within 10 ms. It stays to be
// freed. May come from any thread.
//
// # Safety
// `error` is NULL or a place for a handle.
int32_t taut_cancel(const taut_answers *answers, taut_error **error);

// Frees a request, which cancels it if it runs; a thread that waits for it gets TAUT_PREEMPTED.
// Answers that it gave stay. NULL and requests that are freed are let be.
void taut_answers_free(taut_answers *answers);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* TAUT_H */
