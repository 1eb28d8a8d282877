#pragma once
// A compiled expression as kernels see it, for tests.

#include <gtest/gtest.h>

#include <random>
#include <string>

#include "geometry/sdf/sdf_builder.h"
#include "geometry/sdf/sdf_text.h"
#include "kernels/sdf.h"

namespace spinel {

struct SdfTestScene {
    SdfNode root;
    SdfData data;
    kernels::SceneView view{};

    SdfTestScene(SdfNode node, SdfData built) : root(std::move(node)), data(std::move(built)) { connect(); }
    SdfTestScene(const SdfTestScene&) = delete;

    explicit SdfTestScene(const std::string& text, std::optional<std::pair<vec3, vec3>> bounds = std::nullopt) {
        Result<SdfNode> node = parse_sdf_text(text, "test");
        if (!node) throw std::runtime_error(node.error().message);
        root = *node;
        Result<SdfData> built = build_sdf(SdfGeometry{root, bounds});
        if (!built) throw std::runtime_error(built.error().message);
        data = *std::move(built);
        connect();
    }

    float distance(vec3 p) const { return kernels::sdf_distance(view, 0, p); }
    vec4 gradient(vec3 p) const { return kernels::sdf_distance_gradient(view, 0, p); }
    kernels::Hit closest(const kernels::Ray& ray) const {
        kernels::Hit hit = kernels::no_hit(ray.t_max);
        kernels::sdf_closest(view, 0, ray, hit);
        if (hit.t < ray.t_max) hit.instance = 0;
        return hit;
    }
    bool any(const kernels::Ray& ray) const { return kernels::sdf_any(view, 0, ray); }

    vec3 lower() const { return data.sdf.lower; }
    vec3 upper() const { return data.sdf.upper; }
    float size() const { return glm::length(upper() - lower()); }

  private:
    void connect() {
        view.sdf_ops.at = data.ops.data();
        view.sdfs.at = &data.sdf;
    }
};

class SdfRandom {
  public:
    explicit SdfRandom(unsigned seed) : engine_(seed) {}
    float uniform(float a, float b) { return a + (b - a) * static_cast<float>(engine_()) * 0x1p-32f; }
    vec3 in_box(vec3 a, vec3 b) {
        float x = uniform(a.x, b.x), y = uniform(a.y, b.y), z = uniform(a.z, b.z);
        return vec3(x, y, z);
    }
    vec3 direction() {
        while (true) {
            vec3 v = in_box(vec3(-1), vec3(1));
            float l = glm::length(v);
            if (l > 0.1f && l < 1) return v / l;
        }
    }
    unsigned below(unsigned n) { return static_cast<unsigned>(engine_() % n); }

  private:
    std::mt19937 engine_;
};

}  // namespace spinel
