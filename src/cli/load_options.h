#pragma once
// What a subcommand that reads models offers of LoadOptions.

#include "cli/commands.h"
#include "spinel/formats.h"

namespace spinel::cli {

// Declares --frame and --heightmap.
void add_load_options(CLI::App& app, LoadOptions& options);

// A scene file, or a model as it is, without the light and the ground that a picture of it would get.
Result<Scene> load_bare(const std::string& file, const LoadOptions& options);

}  // namespace spinel::cli
