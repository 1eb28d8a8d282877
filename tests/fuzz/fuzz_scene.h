#pragma once
// What every reader of scenes promises: an error of one line, or a scene that is valid.

#include <cstdio>
#include <cstdlib>
#include <string>

#include "core/result.h"
#include "fuzz_file.h"
#include "scene/validate.h"
#include "spinel/scene.h"

namespace spinel {

inline void check_message(const Error& error) {
    if (!error.message.empty() && error.message.find('\n') == std::string::npos) return;
    std::fprintf(stderr, "not one line: %s\n", error.message.c_str());
    std::abort();
}

inline void check_scene(const Result<Scene>& scene) {
    if (!scene) return check_message(scene.error());
    if (const Result<void> valid = validate(*scene); !valid) {
        std::fprintf(stderr, "accepted, but not valid: %s\n", valid.error().message.c_str());
        std::abort();
    }
}

}  // namespace spinel
