#pragma once
// What is asked of boxes in world space while a scene is compiled.

#include "accel/bvh_builder.h"

namespace spinel {

inline const Box empty_box{glm::vec3(kernels::INFINITE), glm::vec3(-kernels::INFINITE)};

inline bool is_empty(const Box& b) { return !glm::all(glm::lessThanEqual(b.lower, b.upper)); }
inline Box grown(const Box& b, float by) { return {b.lower - by, b.upper + by}; }
inline Box intersection(const Box& a, const Box& b) { return {glm::max(a.lower, b.lower), glm::min(a.upper, b.upper)}; }
inline Box hull(const Box& a, const Box& b) { return {glm::min(a.lower, b.lower), glm::max(a.upper, b.upper)}; }
// The largest coordinate.
inline float magnitude(const Box& b) {
    const glm::vec3 m = glm::max(glm::abs(b.lower), glm::abs(b.upper));
    return glm::max(m.x, glm::max(m.y, m.z));
}

}  // namespace spinel
