#pragma once
// The program's subcommands: one file each, one row each in main.cpp.

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

#include "core/result.h"

namespace spinel::cli {

// Exit codes of the program.
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

// Prints "spinel: message" to stderr and gives exit_bad_input.
int fail(const Error& error);

}  // namespace spinel::cli
