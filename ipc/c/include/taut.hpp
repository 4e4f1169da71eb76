// taut for C++17: taut.h with owners, exceptions and a range of improvements.
//
//     taut::daemon daemon;
//     taut::options options;
//     options.deadline(0.02);
//     for (const taut::answer &best : daemon.shorten("panda", "kitchen", path, options))
//         use(best.length(), best.path());
//
// Every failure throws taut::error, with code, what is not kept and where. Thread-safety is that of taut.h: objects may be used
// from any thread, but not be moved or destroyed by one while another uses them.
#ifndef TAUT_HPP
#define TAUT_HPP

#include "taut.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace taut {

// Where a path does not keep what it must, or is not proved to: world frame.
struct place {
    std::uint32_t kind = 0;         // TAUT_KIND_*
    std::vector<std::string> names; // of a clearance the two bodies
    std::uint32_t segment = 0;      // from 0
    double t = 0;                   // ratio on the segment
    double amount = 0;              // how much is kept: of a clearance the distance, below 0 the depth
    double allowed = 0;             // how much must be kept
    std::uint32_t unit = 0;         // of both, TAUT_UNIT_*
    std::array<std::array<double, 3>, 2> points{}; // metres
    std::array<double, 3> normal{}; // of a clearance from the second body to the first
};

// A call that failed.
class error : public std::runtime_error {
public:
    error(int code, const taut_error *from) : std::runtime_error(text(code, from)), code_(code) {
        retry_after_ms_ = taut_error_retry_after_ms(from);
        taut_place found;
        if (taut_error_place(from, &found, sizeof found)) {
            place_.emplace();
            for (const char *name : found.names)
                if (*name) place_->names.emplace_back(name);
            place_->kind = found.kind;
            place_->segment = found.segment;
            place_->t = found.t;
            place_->amount = found.amount;
            place_->allowed = found.allowed;
            place_->unit = found.unit;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                place_->points[0][axis] = found.points[0][axis];
                place_->points[1][axis] = found.points[1][axis];
                place_->normal[axis] = found.normal[axis];
            }
        }
    }

    int code() const noexcept { return code_; } // TAUT_*
    const char *code_name() const noexcept { return taut_code_name(code_); }
    std::uint32_t retry_after_ms() const noexcept { return retry_after_ms_; } // 0 = never
    const std::optional<taut::place> &where() const noexcept { return place_; }

private:
    static std::string text(int code, const taut_error *from) {
        const char *message = taut_error_message(from);
        return *message ? message : taut_code_name(code);
    }

    int code_;
    std::uint32_t retry_after_ms_ = 0;
    std::optional<taut::place> place_;
};

namespace detail {

// Takes the error of a call, which it throws unless the code is one that is none.
class outcome {
public:
    outcome() = default;
    outcome(const outcome &) = delete;
    outcome &operator=(const outcome &) = delete;
    ~outcome() { taut_error_free(error_); }

    taut_error **slot() { return &error_; }
    int check(int code) const {
        if (code < TAUT_END) throw taut::error(code, error_);
        return code;
    }

private:
    taut_error *error_ = nullptr;
};

template <typename T, void (*Free)(T *)> struct freer {
    void operator()(T *handle) const { Free(handle); }
};
template <typename T, void (*Free)(T *)> using owner = std::unique_ptr<T, freer<T, Free>>;

inline std::vector<const char *> pointers(const std::vector<std::string> &texts) {
    std::vector<const char *> found;
    for (const std::string &text : texts) found.push_back(text.c_str());
    return found;
}

} // namespace detail

// So many numbers of somebody else's.
class row_view {
public:
    row_view(const double *first, std::size_t size) : first_(first), size_(size) {}
    const double *begin() const { return first_; }
    const double *end() const { return first_ + size_; }
    const double *data() const { return first_; }
    std::size_t size() const { return size_; }
    double operator[](std::size_t column) const { return first_[column]; }

private:
    const double *first_;
    std::size_t size_;
};

// A path in shared memory, valid as long as its answer.
class path_view {
public:
    explicit path_view(const taut_rows &rows) : rows_(rows) {}
    std::size_t size() const { return rows_.waypoints; }
    std::size_t columns() const { return rows_.columns; }
    row_view operator[](std::size_t waypoint) const {
        return row_view(rows_.first + waypoint * rows_.stride, rows_.columns);
    }

private:
    taut_rows rows_;
};

// What a request may say beyond robot, scene and path. See taut_options.
class options {
public:
    options() { taut_options_default(&plain, sizeof plain); }

    // Setters, from the table of options:
    // Time that the request may take, from when it is sent; the best path by then is the answer
    options &deadline(double seconds) { return plain.deadline_s = seconds, *this; }
    // Distance that every pair of bodies must keep
    options &clearance(double metres) { return plain.clearance_m = metres, *this; }
    // Most work to spend on a shorter path, in the units of the answer's `work`: the same on every machine
    options &budget(std::uint64_t number) { return plain.work_budget = number, *this; }
    // Seed of every random choice
    options &seed(std::uint64_t number) { return plain.seed = number, *this; }
    // Version of the scene, of those that are kept
    options &scene_version(std::uint64_t number) { return plain.scene_version = number, *this; }
    // Refuse where what a sensor sees of the scene is older than this
    options &max_age(double seconds) { return plain.max_age_s = seconds, *this; }
    // Optimizer: TAUT_MODE_*
    options &mode(std::uint32_t mode) { return plain.mode = mode, *this; }
    // Class of the request: one of a higher class is served first
    options &priority(std::uint32_t number) { return plain.priority = number, *this; }
    // Refuse a path that keeps less, instead of lowering the clearance of the pairs that come closer
    options &strict(bool set) { return plain.strict = set, *this; }
    // Take the columns of continuous joints as they stand, as real numbers and not as angles on the circle
    options &unwrapped(bool set) { return plain.unwrapped = set, *this; }
    // Look for what is nearest along the path; without it the answer comes sooner
    options &contacts(bool set) { return plain.without_contacts = !set, *this; }
    // Mode check only: tell again when a change of the scene makes the path unsafe or safe, until the request is
    // dropped
    options &watch(bool set) { return plain.watch = set, *this; }
    // Keep the goal's numbers: refuse a path whose angles lead there only by a step of more than half a turn, and
    // take no path that ends whole turns away
    options &keep_goal(bool set) { return plain.keep_goal = set, *this; }
    // Prove each segment at the largest clearance that it keeps, up to 10 cm, and tell how far what is executed may
    // stray from the path
    options &corridor(bool set) { return plain.corridor = set, *this; }
    // Names of the path's columns, in the path's order; joints of the robot that are missing stand still
    options &columns(std::vector<std::string> names) { return columns_ = std::move(names), *this; }
    // Where a joint stands that is no column of the path, instead of at 0
    options &hold(std::string name, double value) {
        hold_names_.push_back(std::move(name));
        hold_values_.push_back(value);
        return *this;
    }
    // Weights of the metric, one per velocity coordinate of the robot
    options &weights(std::vector<double> numbers) { return weights_ = std::move(numbers), *this; }
    // Weight of a joint in the metric, by its name, instead of the one that it has
    options &joint_weight(std::string name, double value) {
        joint_weight_names_.push_back(std::move(name));
        joint_weight_values_.push_back(value);
        return *this;
    }
    // Waypoints that stay as they are to the last bit, counted from 0; the ends always do
    options &fixed(std::vector<std::size_t> indices) { return fixed_ = std::move(indices), *this; }
    // Group of the robot: only its joints may move otherwise than on the path given
    options &group(std::string name) { return group_ = std::move(name), *this; }
    // What the path must keep besides clearance, see docs/constraints.md: MoveIt's Constraints in JSON, a list of
    // such, or few words such as "upright hand:x=0.1"
    options &constraints(std::string text) { return constraints_ = std::move(text), *this; }
    // A trajectory along the path, near the least time that the motors allow and proved as it is written, see
    // docs/timing.md: what they allow, and how it is executed. MoveIt's joint_limits.yaml, with our words beside it,
    // or few words such as "acceleration=2/s speed=0.5"
    options &timing(std::string text) { return timing_ = std::move(text), *this; }
    // (end of the table)

    // Calls with what taut.h wants, which lives as long as the call.
    template <typename Call> auto with(Call call) const {
        taut_options given = plain;
        // Arrays, from the table of options:
        const auto columns = detail::pointers(columns_);
        given.columns = columns.data();
        given.column_count = columns.size();
        const auto hold = detail::pointers(hold_names_);
        given.held_names = hold.data();
        given.held_values = hold_values_.data();
        given.held_count = hold.size();
        given.weights = weights_.data();
        given.weight_count = weights_.size();
        const auto joint_weight = detail::pointers(joint_weight_names_);
        given.joint_weight_names = joint_weight.data();
        given.joint_weights = joint_weight_values_.data();
        given.joint_weight_count = joint_weight.size();
        given.fixed_waypoints = fixed_.data();
        given.fixed_count = fixed_.size();
        given.group = group_ ? group_->c_str() : nullptr;
        given.constraints = constraints_ ? constraints_->c_str() : nullptr;
        given.timing = timing_ ? timing_->c_str() : nullptr;
        // (end of the table)
        return call(&given);
    }

    taut_options plain; // its arrays are those of the setters

private:
    // Their memory, from the table of options:
    std::vector<std::string> columns_;
    std::vector<std::string> hold_names_;
    std::vector<double> hold_values_;
    std::vector<double> weights_;
    std::vector<std::string> joint_weight_names_;
    std::vector<double> joint_weight_values_;
    std::vector<std::size_t> fixed_;
    std::optional<std::string> group_;
    std::optional<std::string> constraints_;
    std::optional<std::string> timing_;
    // (end of the table)
};

// A path of the caller's, row by row.
struct path {
    std::vector<double> numbers;
    std::size_t columns = 0;

    path() = default;
    path(std::vector<double> flat, std::size_t width) : numbers(std::move(flat)), columns(width) {}
    path(const std::vector<std::vector<double>> &rows) : columns(rows.empty() ? 0 : rows.front().size()) {
        for (const std::vector<double> &row : rows) {
            if (row.size() != columns) throw std::invalid_argument("taut::path: rows of different lengths");
            numbers.insert(numbers.end(), row.begin(), row.end());
        }
    }

    std::size_t size() const { return columns ? numbers.size() / columns : 0; }
    row_view operator[](std::size_t waypoint) const { return row_view(&numbers[waypoint * columns], columns); }
};

// One answer, in shared memory until it is destroyed. A request can have two at once.
class answer {
public:
    explicit answer(taut_answer *handle) : handle_(handle) {
        detail::outcome outcome;
        outcome.check(taut_answer_info(handle, &info_, sizeof info_, outcome.slot()));
    }

    const taut_info &info() const { return info_; }
    double length() const { return info_.length_after; }
    bool proved() const { return info_.proved; }
    bool is_final() const { return info_.is_final; }
    // In place. Throws where the request's columns are in another order than the robot's: then copy().
    path_view path() const {
        taut_rows rows;
        detail::outcome outcome;
        outcome.check(taut_answer_rows(handle_.get(), &rows, sizeof rows, outcome.slot()));
        return path_view(rows);
    }
    // What a person should know, first what the verdict does not cover (`uncovered`).
    struct warning {
        std::string text;
        bool uncovered;
    };
    std::vector<warning> warnings() const {
        std::vector<warning> found;
        taut_warning one;
        for (std::size_t index = 0; taut_answer_warning(handle_.get(), index, &one); ++index)
            found.push_back({one.text, one.uncovered});
        return found;
    }
    // What a proved path keeps of each constraint, of its tolerance as it is asked.
    struct kept {
        std::string name;
        std::uint32_t kind, unit;    // TAUT_KIND_*, TAUT_UNIT_*
        std::optional<double> asked; // the tolerance, where one number says it: what is read is asked - left at most
        double left;                 // proved to be left everywhere along the path
        double found;                // the least that was found to be left: a look, no proof
        std::size_t segment;         // where that is, from 0
        double t;                    // and the ratio on it
    };
    std::vector<kept> keeps() const {
        std::vector<kept> found;
        taut_kept one;
        for (std::size_t index = 0; taut_answer_kept(handle_.get(), index, &one, sizeof one); ++index)
            found.push_back({one.name, one.kind, one.unit,
                one.asked > 0 ? std::optional<double>(one.asked) : std::nullopt, one.left, one.found, one.segment, one.t});
        return found;
    }
    // How far what is executed may stray from the path; none unless options::corridor asked for it and it is proved.
    struct corridor_data {
        double floor;              // metres that every pair keeps within it
        std::vector<double> reach; // metres per rad or m of each velocity coordinate
        std::vector<double> slack; // metres, of each segment
    };
    std::optional<corridor_data> corridor() const {
        taut_corridor found;
        if (!taut_answer_corridor(handle_.get(), &found, sizeof found)) return std::nullopt;
        return corridor_data{found.floor_m, {found.reach, found.reach + found.reach_count},
            {found.slack_m, found.slack_m + found.slack_count}};
    }
    // When what is to be where, of a request with options::timing: proved as it is written, at every instant. Rows in
    // the request's columns. Throws taut::error with TAUT_UNTIMED where there is none, with why; the path is there all
    // the same.
    struct trajectory_data {
        std::vector<std::int64_t> times_ns; // from the start
        std::size_t columns;
        std::vector<double> positions;     // rad or m
        std::vector<double> velocities;    // per s; empty where the controller goes straight
        std::vector<double> accelerations; // per s^2; empty where a controller that had them would go another way
        taut_trajectory figures;           // its pointers are valid as long as the answer
    };
    trajectory_data trajectory() const {
        taut_trajectory found;
        detail::outcome outcome;
        outcome.check(taut_answer_trajectory(handle_.get(), &found, sizeof found, outcome.slot()));
        const auto table = [&](const double *first) {
            return first ? std::vector<double>(first, first + found.points * found.columns) : std::vector<double>();
        };
        return {{found.times_ns, found.times_ns + found.points}, found.columns, table(found.positions),
            table(found.velocities), table(found.accelerations), found};
    }
    // To keep, in the request's columns.
    taut::path copy() const {
        taut::path copied(std::vector<double>(info_.waypoints * info_.columns), info_.columns);
        detail::outcome outcome;
        outcome.check(
            taut_answer_copy(handle_.get(), copied.numbers.data(), copied.numbers.size(), outcome.slot()));
        return copied;
    }

private:
    detail::owner<taut_answer, taut_answer_free> handle_;
    taut_info info_;
};

// A request in flight; destroying it cancels it.
class answers {
public:
    explicit answers(taut_answers *handle) : handle_(handle) {}

    // The next answer; none after the final one, or when nothing came within `seconds`.
    std::optional<answer> next(double seconds = std::numeric_limits<double>::infinity()) {
        return receive(taut_next, seconds);
    }
    // The final answer; throws TAUT_TIMED_OUT if it does not come within `seconds`.
    answer result(double seconds = std::numeric_limits<double>::infinity()) {
        if (std::optional<answer> found = receive(taut_result, seconds)) return std::move(*found);
        throw error(TAUT_TIMED_OUT, nullptr);
    }
    void finish_early() {
        detail::outcome outcome;
        outcome.check(taut_finish_early(handle_.get(), outcome.slot()));
    }
    void cancel() {
        detail::outcome outcome;
        outcome.check(taut_cancel(handle_.get(), outcome.slot()));
    }

    // The answers as they come; each lives until the next is taken.
    class iterator {
    public:
        using iterator_category = std::input_iterator_tag;
        using value_type = answer;
        using difference_type = std::ptrdiff_t;
        using pointer = const answer *;
        using reference = const answer &;

        iterator() = default;
        explicit iterator(answers *from) : from_(from), current_(std::make_shared<std::optional<answer>>()) { ++*this; }
        reference operator*() const { return **current_; }
        pointer operator->() const { return &**current_; }
        iterator &operator++() {
            current_->reset();
            *current_ = from_->next();
            if (!*current_) from_ = nullptr;
            return *this;
        }
        void operator++(int) { ++*this; }
        bool operator==(const iterator &other) const { return from_ == other.from_; }
        bool operator!=(const iterator &other) const { return from_ != other.from_; }

    private:
        answers *from_ = nullptr;
        std::shared_ptr<std::optional<answer>> current_;
    };
    iterator begin() { return iterator(this); }
    iterator end() { return iterator(); }

private:
    using receiver = decltype(&taut_next);
    std::optional<answer> receive(receiver call, double seconds) {
        taut_answer *found = nullptr;
        detail::outcome outcome;
        outcome.check(call(handle_.get(), seconds, &found, outcome.slot()));
        return found ? std::optional<answer>(std::in_place, found) : std::nullopt;
    }

    detail::owner<taut_answers, taut_answers_free> handle_;
};

// Files of a robot.
struct robot_files {
    std::string urdf;
    std::optional<std::string> srdf;
    std::vector<std::pair<std::string, std::string>> packages; // name, folder
};

// A variable of a robot: rad or m.
struct variable {
    std::string name;
    double lower, upper;
    bool continuous;
};

// A connection. One per process is enough.
class daemon {
public:
    // NAME or NAME:ROOT of an instance; NULL = the one that TAUT_INSTANCE names, or the default one.
    explicit daemon(const char *instance = nullptr) {
        taut_daemon *found = nullptr;
        detail::outcome outcome;
        outcome.check(taut_connect(instance, &found, outcome.slot()));
        handle_.reset(found);
    }

    std::vector<variable> load_robot(const std::string &label, const robot_files &files, bool replace = false) {
        taut_robot_files given{};
        std::vector<std::string> names, folders;
        for (const auto &[name, folder] : files.packages) names.push_back(name), folders.push_back(folder);
        const auto package_names = detail::pointers(names), package_folders = detail::pointers(folders);
        given.size = sizeof given;
        given.urdf = files.urdf.c_str();
        given.srdf = files.srdf ? files.srdf->c_str() : nullptr;
        given.package_names = package_names.data();
        given.package_folders = package_folders.data();
        given.package_count = names.size();
        taut_robot *robot = nullptr;
        detail::outcome outcome;
        outcome.check(taut_load_robot(handle_.get(), label.c_str(), &given, replace, &robot, outcome.slot()));
        return variables_of(robot);
    }
    // Variables of a robot that is loaded, in its order.
    std::vector<variable> variables(const std::string &label) const {
        taut_robot *robot = nullptr;
        detail::outcome outcome;
        outcome.check(taut_describe_robot(handle_.get(), label.c_str(), &robot, outcome.slot()));
        return variables_of(robot);
    }

    taut_scene_info load_scene(const std::string &label, const std::string &json, bool replace = false) {
        return scene([&](taut_scene_info *info, taut_error **slot) {
            return taut_load_scene(
                handle_.get(), label.c_str(), json.c_str(), nullptr, replace, info, sizeof *info, slot);
        });
    }
    taut_scene_info change_scene(const std::string &label, const std::string &diff, std::uint64_t base = 0) {
        return scene([&](taut_scene_info *info, taut_error **slot) {
            return taut_change_scene(
                handle_.get(), label.c_str(), diff.c_str(), nullptr, base, info, sizeof *info, slot);
        });
    }
    taut_scene_info move(const std::string &label, const std::string &object, const taut_pose &pose) {
        return scene([&](taut_scene_info *info, taut_error **slot) {
            return taut_move_object(
                handle_.get(), label.c_str(), object.c_str(), nullptr, &pose, info, sizeof *info, slot);
        });
    }
    taut_scene_info attach(const std::string &label, const std::string &object, const std::string &link,
        const taut_pose &pose, const std::vector<std::string> &touch_links = {}) {
        return scene([&](taut_scene_info *info, taut_error **slot) {
            const auto touch = detail::pointers(touch_links);
            return taut_attach_object(handle_.get(), label.c_str(), object.c_str(), link.c_str(), &pose,
                touch.data(), touch.size(), info, sizeof *info, slot);
        });
    }
    taut_scene_info detach(const std::string &label, const std::string &object, const taut_pose &pose) {
        return scene([&](taut_scene_info *info, taut_error **slot) {
            return taut_detach_object(
                handle_.get(), label.c_str(), object.c_str(), &pose, info, sizeof *info, slot);
        });
    }
    taut_scene_info remove(const std::string &label, const std::string &object) {
        return scene([&](taut_scene_info *info, taut_error **slot) {
            return taut_remove_object(handle_.get(), label.c_str(), object.c_str(), info, sizeof *info, slot);
        });
    }

    // Sends a path to be shortened. An empty scene label is nothing around the robot.
    answers shorten(const std::string &robot, const std::string &scene, const path &path,
        const taut::options &options = {}) const {
        return options.with([&](const taut_options *given) {
            taut_answers *found = nullptr;
            detail::outcome outcome;
            outcome.check(taut_shorten(handle_.get(), robot.c_str(), scene.empty() ? nullptr : scene.c_str(),
                path.numbers.data(), path.size(), path.columns, given, &found, outcome.slot()));
            return answers(found);
        });
    }
    // Proves a path as it is; throws where it is not free, with bodies and place.
    taut_info check(const std::string &robot, const std::string &scene, const path &path,
        const taut::options &options = {}) const {
        return options.with([&](const taut_options *given) {
            taut_info info;
            detail::outcome outcome;
            outcome.check(taut_check(handle_.get(), robot.c_str(), scene.empty() ? nullptr : scene.c_str(),
                path.numbers.data(), path.size(), path.columns, given, &info, sizeof info, outcome.slot()));
            return info;
        });
    }

private:
    static std::vector<variable> variables_of(taut_robot *robot) {
        const detail::owner<taut_robot, taut_robot_free> owned(robot);
        std::vector<variable> found;
        taut_variable one;
        for (std::size_t index = 0; taut_robot_variable(robot, index, &one); ++index)
            found.push_back({one.name, one.lower, one.upper, one.continuous});
        return found;
    }
    template <typename Call> static taut_scene_info scene(Call call) {
        taut_scene_info info;
        detail::outcome outcome;
        outcome.check(call(&info, outcome.slot()));
        return info;
    }

    detail::owner<taut_daemon, taut_close> handle_;
};

} // namespace taut

#endif // TAUT_HPP
