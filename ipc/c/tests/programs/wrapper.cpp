// The C++ wrapper, right and wrong: wrapper PATH. Robot and scene "arm_window" are loaded.
#include "taut.hpp"

#include "common.h"

#include <iostream>

template <typename Call> static taut::error refused(Call call) {
    try {
        call();
    } catch (const taut::error &error) {
        return error;
    }
    CHECK(!"refused");
    std::abort();
}

int main(int count, char **arguments) {
    CHECK(count == 2);
    const test_path read = read_path(arguments[1]);
    const taut::path path(std::vector<double>(read.numbers, read.numbers + read.waypoints * read.columns), read.columns);
    free(read.numbers);

    taut::daemon daemon;
    CHECK(daemon.variables("arm_window").at(6).name == "joint7");

    // The improvements, in place, and the last one to keep.
    taut::options options;
    options.budget(20000).priority(2).scene_version(1).corridor(true);
    double length = std::numeric_limits<double>::infinity();
    taut::path kept;
    for (const taut::answer &best : daemon.shorten("arm_window", "arm_window", path, options)) {
        CHECK(best.proved() && best.length() <= length);
        CHECK(best.path().columns() == 7 && best.path()[0][0] == path[0][0]);
        length = best.length();
        if (!best.is_final()) continue;
        kept = best.copy();
        const auto corridor = best.corridor();
        CHECK(corridor && corridor->reach.size() == 7 && corridor->slack.size() == kept.size() - 1);
        CHECK(corridor->floor > 0 && corridor->slack[0] >= 0);
    }
    CHECK(kept.size() > 1 && kept.columns == 7 && kept[0][3] == path[0][3]);
    CHECK(daemon.check("arm_window", "arm_window", kept).length_after == length);

    options.corridor(false).scene_version(0);
    CHECK(!daemon.shorten("arm_window", "arm_window", path, options).result().corridor());

    // What is kept besides clearance.
    taut::options upright;
    const auto keeps = daemon.shorten("arm_window", "arm_window", path,
        upright.budget(20000).constraints("keep hand in ball 3 at 0,0,0")).result().keeps();
    CHECK(keeps.size() == 1 && keeps[0].name == "hand" && keeps[0].asked == 3.0);
    CHECK(keeps[0].left > 0 && keeps[0].left <= keeps[0].found);
    options.constraints("upright hand:z=0.001@start");
    const taut::error tilted = refused([&] { daemon.check("arm_window", "arm_window", path, options); });
    CHECK(tilted.where() && tilted.where()->kind == TAUT_KIND_ORIENTATION && tilted.where()->amount < 0);
    CHECK(tilted.where()->names.at(0) == "upright: hand");
    options.constraints("");

    // Named columns, a group, a held waypoint; moved objects; half a loop.
    options.columns({"joint1", "joint2", "joint3", "joint4", "joint5", "joint6", "joint7"}).group("arm").fixed({1});
    taut::answers all = daemon.shorten("arm_window", "arm_window", path, options);
    for (const taut::answer &best : all) {
        CHECK(best.path()[1][2] == path[1][2] || best.path().size() != path.size());
        break;
    }
    taut::answers moved = std::move(all);
    moved.cancel();
    CHECK(refused([&] { moved.next(); }).code() == TAUT_PREEMPTED);

    // A failure has code, what is not kept, and where.
    const char *box = R"({"is_diff": true, "objects": [{"id": "crate", "operation": "ADD", "primitives": [{"type": "box",
        "dimensions": [2, 2, 2]}], "primitive_poses": [{"position": [0.6, 0, 0.5]}]}]})";
    const taut_scene_info scene = daemon.change_scene("arm_window", box);
    const taut::error hit = refused([&] { daemon.check("arm_window", "arm_window", path); });
    CHECK(hit.code() == TAUT_START_STATE_IN_COLLISION && hit.where() && hit.where()->amount < 0);
    CHECK(hit.where()->names.at(0) == "crate" || hit.where()->names.at(1) == "crate");
    CHECK(std::string(hit.code_name()) == "START_STATE_IN_COLLISION");
    const taut::error conflict = refused([&] { daemon.change_scene("arm_window", box, scene.version - 1); });
    CHECK(conflict.code() == TAUT_VERSION_CONFLICT && !conflict.where());
    CHECK(daemon.remove("arm_window", "crate").objects == scene.objects - 1);
    CHECK(refused([&] { daemon.shorten("nobody", "", path); }).code() == TAUT_UNKNOWN_ROBOT);
    CHECK(refused([&] { daemon.shorten("arm_window", "", {{1, 2}, 2}); }).code() == TAUT_INVALID_ROBOT_STATE);
    CHECK(refused([] { taut::daemon nobody("nobody"); }).code() == TAUT_DAEMON_LOST);
    std::cout << "the wrapper wraps\n";
}
