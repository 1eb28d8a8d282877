#pragma once
// The program's subcommands: one file each, one row each in main.cpp.

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "core/result.h"

namespace CLI {
class App;
class Validator;
}  // namespace CLI

namespace spinel::cli {

// Exit codes of the program. Usage is what the command line itself says: an unknown option, a value that is not one of
// the allowed ones (names of tables, sizes, the extension of an output). Input is what files hold, or do not.
enum ExitCode { exit_ok = 0, exit_bad_input = 1, exit_usage = 2, exit_comparison_failed = 3 };

// What every subcommand understands.
struct CommonOptions {
    bool quiet = false;  // errors only
    bool json = false;   // results as JSON on stdout
};

// Declares options on its own CLI::App and returns what runs once they are parsed.
using Command = std::function<int()> (*)(CLI::App& app, const CommonOptions& common);

std::function<int()> render_command(CLI::App& app, const CommonOptions& common);
std::function<int()> info_command(CLI::App& app, const CommonOptions& common);
std::function<int()> list_command(CLI::App& app, const CommonOptions& common);
std::function<int()> trace_command(CLI::App& app, const CommonOptions& common);
std::function<int()> bench_command(CLI::App& app, const CommonOptions& common);
std::function<int()> compare_command(CLI::App& app, const CommonOptions& common);
std::function<int()> convert_command(CLI::App& app, const CommonOptions& common);
std::function<int()> generate_command(CLI::App& app, const CommonOptions& common);

// For options that are numbers: NaN passes every range check of CLI11.
CLI::Validator finite_number();

// Names of files may be any bytes, JSON is UTF-8: what is not becomes U+FFFD.
std::string json_text(const nlohmann::ordered_json& json, int indent);

// Prints "spinel: message" to stderr and gives the exit code.
int fail(const Error& error, ExitCode code = exit_bad_input);

}  // namespace spinel::cli
