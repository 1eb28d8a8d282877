#pragma once
// "animation" of a scene file: values of the file as formulas of time. They are put in place before anything is read,
// so whatever a file may say may move.

#include "core/result.h"
#include "scene/json_document.h"
#include "spinel/formats.h"

namespace spinel {

// Evaluates "animation" of the document, if it has one, and writes the values of that moment where they belong. A frame
// that is asked for of a document without one is an error.
Result<void> apply_animation(JsonDocument& document, const Moment& moment);

}  // namespace spinel
