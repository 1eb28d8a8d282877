#pragma once
// What a mesh file announces, held against what it can hold: Assimp allocates what it is told, and reads on for ever
// where a header ends early.

#include <cstdint>
#include <filesystem>
#include <string_view>

#include "core/result.h"

namespace spinel {

constexpr std::uintmax_t MAX_MESH_FILE = std::uintmax_t(1) << 32;  // bytes

// PLY: a whole header of known words; elements and lists that fit the bytes behind it.
Result<void> check_ply(const std::filesystem::path& path);

// OFF: as many lines as are announced, faces of corners that are there.
Result<void> check_off(const std::filesystem::path& path);

// Whether JSON is nested deeper than `depth`: parsers by recursion have no other end.
bool is_nested_deeper(std::string_view json, int depth);

}  // namespace spinel
