// spinel: the command line. Messages go to stderr, results to stdout.

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>
#include <nlohmann/json.hpp>
#include <optional>

#include "cli/commands.h"

namespace spinel::cli {

int fail(const Error& error, ExitCode code) {
    fmt::print(stderr, "spinel: {}\n", error.message);
    return code;
}

CLI::Validator finite_number() {
    return CLI::Validator(
        [](const std::string& text) {
            return std::isfinite(std::strtod(text.c_str(), nullptr)) ? "" : "'" + text + "' is not a finite number";
        },
        "");
}

std::string json_text(const nlohmann::ordered_json& json, int indent) {
    return json.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

namespace {

struct Row {
    const char* name;
    const char* doc;
    const char* example;
    Command command;
};

constexpr Row commands[] = {
    {"render", "make a picture of a scene or of any model",
     "  spinel render castle.vox -o castle.png\n"
     "  spinel render scene.json -o scene.exr --spp 256 --aov depth,normal\n"
     "  spinel render scene.json -o quick.png --time 10s --size 640x360\n"
     "  spinel render models/*.vox -o pictures/",
     render_command},
    {"info", "tell what is in a file",
     "  spinel info castle.vox\n"
     "  spinel info scene.json --json",
     info_command},
    {"list", "tell what is registered: materials, formats, integrators, …",
     "  spinel list materials\n"
     "  spinel list",
     list_command},
    {"trace", "send a batch of rays into a scene",
     "  spinel trace bunny.ply --rays rays.npy -o hits.npy\n"
     "  spinel trace scene.json --rays rays.npy -o hits.npy --accel brute-force",
     trace_command},
    {"bench", "measure what answers rays: structures side by side",
     "  spinel bench monu3.vox\n"
     "  spinel bench --voxels terrain.vdb --from 120.3,205.7,90.2 --at 600,60,640 --size 1024 --json",
     bench_command},
    {"compare", "tell how far two pictures are apart",
     "  spinel compare picture.png reference.png --metric flip\n"
     "  spinel compare picture.exr reference.exr --metric mean --threshold 0.01",
     compare_command},
    {"convert", "make voxels of meshes, implicit surfaces and volumes, or meshes of voxels",
     "  spinel convert dragon.ply -o dragon.vdb --voxels 512 --solid\n"
     "  spinel convert brain.svol -o brain.vdb --threshold 0.4\n"
     "  spinel convert castle.vox -o castle.obj",
     convert_command},
    {"generate", "make a world of voxels",
     "  spinel generate city -o city.vdb --size 512x160x512 --seed 7\n"
     "  spinel list worlds",
     generate_command},
};

// One line; CLI11 spreads some complaints over several, and calls an unknown subcommand a missing one.
std::string usage_message(const CLI::App& app, const CLI::ParseError& error, int argc, char** argv) {
    std::string message = error.what(), names;
    std::replace(message.begin(), message.end(), '\n', ' ');
    const std::vector<CLI::App*> chosen = app.get_subcommands();
    if (!chosen.empty()) return fmt::format("{}; see spinel {} --help", message, chosen[0]->get_name());
    for (const Row& row : commands) names += (names.empty() ? "" : ", ") + std::string(row.name);
    if (argc > 1 && argv[1][0] != '-') message = fmt::format("unknown subcommand '{}'", argv[1]);
    return fmt::format("{}; available: {}; see spinel --help", message, names);
}

int run(int argc, char** argv) {
    CLI::App app{"Spinel: path-traced pictures of voxels, volumes, implicit surfaces and meshes.", "spinel"};
    app.require_subcommand(1);
    app.set_version_flag("--version", SPINEL_VERSION);
    CommonOptions common;
    std::function<int()> chosen;
    for (const Row& row : commands) {
        CLI::App* sub = app.add_subcommand(row.name, row.doc);
        sub->footer(std::string("Examples:\n") + row.example);
        sub->add_flag("--quiet", common.quiet, "say nothing but errors");
        sub->add_flag("--json", common.json, "results as JSON on stdout");
        const std::function<int()> action = row.command(*sub, common);
        sub->final_callback([&chosen, action] { chosen = action; });
    }
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        if (error.get_exit_code() == 0) return app.exit(error);  // prints help or the version
        return fail({usage_message(app, error, argc, argv)}, exit_usage);
    }
    return chosen();
}

}  // namespace
}  // namespace spinel::cli

int main(int argc, char** argv) {
    // The library reports through Result; what still arrives here is the machine running out, or a bug.
    try {
        return spinel::cli::run(argc, argv);
    } catch (const std::bad_alloc&) {
        fmt::print(stderr, "spinel: out of memory\n");
    } catch (const std::exception& error) { fmt::print(stderr, "spinel: internal error: {}\n", error.what()); }
    return spinel::cli::exit_bad_input;
}
