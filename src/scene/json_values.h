#pragma once
// The way back: a member that a row describes, as a JSON value.

#include <nlohmann/json.hpp>

#include "scene/scene_fields.h"

namespace spinel {

// Key order is that of insertion, so that files read as they are written.
using OrderedJson = nlohmann::ordered_json;

// A float as the shortest decimal that reads back the same: 0.1, not 0.10000000149011612.
OrderedJson json_number(float x);

// The value of a row's member in `record`, an instance of the row's struct; null for rows read by hand. A
// colour of three equal channels is one number.
OrderedJson json_value(const Field& field, const void* record);

}  // namespace spinel
