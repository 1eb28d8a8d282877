#pragma once
// What `convert` and `generate` share: the format that a file is written in, and what is told of it.

#include <string>

#include "cli/commands.h"
#include "spinel/formats.h"

namespace spinel::cli {

// By the extension; an error names those that can be written. Where `voxels` is asked for, only those that hold any.
Result<const Format*> output_format(const std::string& path, bool voxels = false);

// One line on stderr, or an object on stdout with --json. Before it the scene's notes, and `left_out`, what the format
// could not hold, as warnings.
void report_saved(const Scene& scene, const Notes& left_out, const std::string& path, double seconds,
                  const CommonOptions& common);

}  // namespace spinel::cli
