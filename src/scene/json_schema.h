#pragma once
// What is published about scene files, made from the tables that the reader reads by.

#include <string>

namespace spinel {

// JSON Schema (draft 7) of a scene file: docs/scene.schema.json.
std::string scene_schema();

// The tables of the reference page, in Markdown: the part of docs/scene.md between its markers.
std::string scene_reference();

}  // namespace spinel
