#pragma once
// How an OpenVDB file is laid out, seen without OpenVDB, which believes every count that a file states. Before it gets
// a file, this makes sure that the file is whole, and that all names, metadata and grids that it lists fit into it.
//
// What lies inside of a grid (its tree and compressed values) is OpenVDB's to read: a file that is made to harm, and
// not only cut off or damaged, is not to be trusted.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"

namespace spinel {

struct VdbGridEntry {
    std::string name;
    std::string type;  // "Tree_int32_5_4_3"
};

// The grids of a file. A file that was written as a stream does not tell where its grids end: of such only the first is
// listed, and whether it is whole shows when it is read.
Result<std::vector<VdbGridEntry>> read_vdb_layout(const std::filesystem::path& path);

}  // namespace spinel
