// A planner in C++17: loads a robot and a scene, has a path shortened, prints each improvement, keeps the last.
//
//   g++ -std=c++17 -Iipc/c/include examples/cpp/shorten.cpp -Ltarget/release -ltaut -Wl,-rpath,$PWD/target/release -o shorten
//   ./shorten config
#include "taut.hpp"

#include <fstream>
#include <iostream>
#include <sstream>

// What a planner found: turn to a wall, reach through its window (config/problems/arm_window.json).
static const taut::path planned = std::vector<std::vector<double>>{
    {-1.5, -0.4, 0.0, -2.2, 0.0, 1.9, 0.785},
    {-1.437788, -0.329843, 0.387754, -2.488961, -0.084143, 1.569325, -0.097564},
    {-1.240192, -0.487351, 0.635639, -2.506844, 0.533576, 1.897626, 0.465073},
    {-1.133743, -0.572205, 0.76918, -2.516478, 0.866355, 2.074489, 0.768179},
    {-0.930693, -0.759014, 1.080606, -2.462474, 0.903104, 2.337022, 1.343845},
    {-1.169123, -0.872609, 1.305671, -2.331107, 1.552551, 2.257014, 1.113459},
    {-1.284336, -1.197473, 1.214081, -2.315599, 1.304429, 2.469726, 1.714743},
    {-1.578729, -1.185159, 1.253734, -2.256439, 2.077625, 2.353562, 1.658777},
    {-1.6131, -1.466, 1.3759, -2.1759, 2.819, 2.4679, 2.1542}};

static std::string text_of(const std::string &name) {
    std::ostringstream text;
    text << std::ifstream(name).rdbuf();
    return text.str();
}

int main(int count, char **arguments) try {
    const std::string config = count > 1 ? arguments[1] : "config";

    // Once.
    taut::daemon daemon;
    daemon.load_robot("cpp_arm", {config + "/robots/panda_like.urdf", config + "/robots/panda_like.srdf", {}});
    daemon.load_scene("cpp_window", text_of(config + "/scenes/arm_window.json"));

    // For each path.
    taut::path kept;
    for (const taut::answer &best : daemon.shorten("cpp_arm", "cpp_window", planned, taut::options().deadline(5))) {
        std::cout << "length " << best.info().length_before << " -> " << best.length() << ", "
                  << best.path().size() << " waypoints, " << (best.proved() ? "proved" : "not proved")
                  << ", joint1 of the second is " << best.path()[1][0] << '\n'; // in shared memory
        if (best.is_final()) kept = best.copy();
    }
    std::cout << "kept " << kept.size() << " waypoints\n";
    return 0;
} catch (const taut::error &error) {
    std::cerr << error.code_name() << ": " << error.what() << '\n';
    if (const auto &place = error.where()) {
        for (const auto &name : place->names) std::cerr << "  " << name;
        std::cerr << ", segment " << place->segment << '\n';
    }
    return 1;
}
