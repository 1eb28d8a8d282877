#pragma once
// What a file has no words for, gathered while a scene is written.

#include <string>

#include "spinel/formats.h"

namespace spinel {

class LeftOut {
  public:
    void add(const std::string& what) { list_ += (list_.empty() ? "" : ", ") + what; }

    // What hardly a file of shapes can hold.
    void add_light_and_cameras(const Scene& scene) {
        if (!scene.lights.empty()) add("lights");
        if (!std::holds_alternative<std::monostate>(scene.environment)) add("the environment");
        if (!scene.cameras.empty()) add("cameras");
    }

    // None, or one sentence.
    Notes notes() const {
        if (list_.empty()) return {};
        return {"what the format has no words for is left out or changed: " + list_};
    }

  private:
    std::string list_;
};

}  // namespace spinel
