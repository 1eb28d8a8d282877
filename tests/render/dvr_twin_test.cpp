// `dvr` against its naive twin: all steps along a ray, whatever is there, each asked whether it is inside of what is
// shown; colours summed from the far end to the near one.

#include "kernels/camera.h"
#include "kernels/dvr.h"
#include "kernels/traverse.h"
#include "render/dvr_volumes.h"

namespace spinel::dvr_twin_test {
namespace {

using namespace test;
using kernels::DvrSettings;
using kernels::SceneView;

class Twin {
  public:
    Twin(const CompiledScene& scene, const kernels::Ray& ray) : Twin(scene.view(), scene.dvr, ray) {}
    Twin(const SceneView& view, const DvrSettings& settings, const kernels::Ray& ray)
        : view_(view), s_(settings), m_(view_.media.at[s_.medium]), ray_(ray) {}

    vec3 color() const {
        if (s_.mode == kernels::DVR_COMPOSITE) return composite();
        if (s_.mode == kernels::DVR_ISOSURFACE) return isosurface();
        return projection();
    }

  private:
    // Depths looked at are whole steps from the camera.
    static constexpr int farthest = 600;

    vec3 index(float t) const { return m_.world_to_grid * vec4(ray_.origin + t * ray_.direction, 1); }
    float value(float t) const { return kernels::dvr_value(view_, m_, index(t)); }
    bool shown(float t) const {
        const vec3 p = index(t);
        for (int a = 0; a < 3; ++a)
            if (p[a] < s_.clip_lower[a] || p[a] > s_.clip_upper[a]) return false;
        for (kernels::uint i = 0; i < s_.plane_count; ++i)
            if (glm::dot(vec3(s_.planes[i]), ray_.origin + t * ray_.direction) > s_.planes[i].w) return false;
        return true;
    }

    vec3 lit(float t, vec3 color) const {
        vec3 gradient(0);
        const vec3 p = index(t);
        for (int a = 0; a < 3; ++a) {
            vec3 d(0);
            d[a] = 1;
            gradient[a] = kernels::dvr_value(view_, m_, p + d) - kernels::dvr_value(view_, m_, p - d);
        }
        gradient = glm::transpose(glm::mat3(m_.world_to_grid)) * gradient;
        const vec3 l = s_.headlight ? -ray_.direction : s_.to_light;
        vec3 out = color;
        if (s_.shaded && glm::length(gradient) > 1e-15f) {
            const vec3 n = glm::normalize(gradient), half = glm::normalize(l - ray_.direction);
            out = color * (s_.ambient + s_.diffuse * std::abs(glm::dot(n, l))) +
                  s_.specular * std::pow(std::abs(glm::dot(n, half)), s_.shininess);
        }
        // What is cut away casts no shadow.
        float depth = 0;
        for (int i = 1; float(i) * 2 * s_.voxel <= s_.shadow_reach; ++i) {
            const kernels::Ray way(ray_.origin + t * ray_.direction, 0, l, kernels::INFINITE);
            const Twin toward(view_, s_, way);
            const float along = float(i) * 2 * s_.voxel;
            if (!toward.shown(along)) continue;
            depth += kernels::transfer_at(view_, s_, kernels::transfer_place(s_, toward.value(along))).w * 2 * s_.voxel;
        }
        return out * (1 - s_.shadow * (1 - std::exp(-depth)));
    }

    vec3 composite() const {
        vec3 color = s_.background;
        for (int k = farthest; k > 0; --k) {
            const float t0 = float(k - 1) * s_.step, t1 = float(k) * s_.step;
            if (!shown(t0) || !shown(t1)) continue;
            const vec4 mean = kernels::transfer_between(view_, s_, kernels::transfer_place(s_, value(t0)),
                                                        kernels::transfer_place(s_, value(t1)));
            const float opacity = 1 - std::exp(-mean.w * s_.step);
            if (opacity > 0) color = opacity * lit(0.5f * (t0 + t1), vec3(mean) / mean.w) + (1 - opacity) * color;
        }
        return color;
    }

    vec3 projection() const {
        float greatest = -1e30f, sum = 0;
        int count = 0;
        for (int k = farthest; k >= 0; --k) {
            const float t = float(k) * s_.step;
            if (!shown(t)) continue;
            greatest = std::max(greatest, value(t));
            sum += value(t);
            ++count;
        }
        if (count == 0) return s_.background;
        const float shown_value = s_.mode == kernels::DVR_MAXIMUM ? greatest : sum / float(count);
        const vec4 row = kernels::transfer_at(view_, s_, kernels::transfer_place(s_, shown_value));
        return row.w > 0 ? vec3(row) / row.w : s_.background;
    }

    // In steps of a twentieth, the nearest place last.
    vec3 isosurface() const {
        const float fine = s_.step / 20;
        float nearest = -1;
        for (int k = 20 * farthest; k >= 0; --k)
            if (shown(float(k) * fine) && value(float(k) * fine) >= s_.iso) nearest = float(k) * fine;
        return nearest < 0 ? s_.background : lit(nearest, s_.iso_color);
    }

    SceneView view_;
    const DvrSettings& s_;
    const kernels::Medium& m_;
    kernels::Ray ray_;
};

class DvrTwin : public Dvr {
  protected:
    // Root mean square and greatest difference over the pixels, in linear units.
    struct Differences {
        double rms = 0, worst = 0, mean = 0;
    };
    Differences differences(const std::string& options, bool shortcuts) {
        Differences d;
        const Result<CompiledScene> compiled = compile_text(
            scene(fmt::format("{}, \"shortcuts\": {}, \"background\": [0.1, 0.2, 0.3]", options, shortcuts), oblique,
                  pixels));
        EXPECT_TRUE(compiled) << compiled.error().message;
        if (!compiled) return d;
        const TestPicture p = render_scene(*compiled, 1, 1, 7);
        for (int y = 0; y < pixels; ++y)
            for (int x = 0; x < pixels; ++x) {
                // The ray of the only sample.
                kernels::Sampler numbers = kernels::make_sampler({x, y}, 0, 7);
                const vec2 u_film = kernels::sampler_2d(numbers), u_lens = kernels::sampler_2d(numbers);
                const kernels::Ray ray = kernels::camera_ray(compiled->view().camera, {x, y}, u_film, u_lens);
                const vec3 expected = Twin(*compiled, ray).color();
                const dvec3 got = p.batches[0][std::size_t(y * pixels + x)];
                for (int k = 0; k < 3; ++k) {
                    const double difference = std::abs(got[k] - double(expected[k]));
                    d.worst = std::max(d.worst, difference);
                    d.rms += difference * difference;
                    d.mean += got[k];
                }
            }
        const double n = 3.0 * pixels * pixels;
        d.rms = std::sqrt(d.rms / n);
        d.mean /= n;
        return d;
    }
    static constexpr int pixels = 28;
};

// Early termination, faint steps, 16 bits and steps at the very faces are what may differ.
TEST_F(DvrTwin, what_is_seen_is_the_sum_from_back_to_front) {
    write(32, ball);
    const std::string layer = layers;
    for (const std::string& o :
         {layer, layer + R"(, "light": "scene", "specular": 0.6)", layer + R"(, "step": 0.5, "shaded": false)",
          layer + R"(, "clip_lower": [0.2, 0, 0.1], "clip_upper": [1, 0.7, 0.9])",
          layer + R"(, "clip_planes": [[0, 0.6, 0.8, 0.75], [1, 0, 0, 0.7]])",
          layer + R"(, "light": "scene", "shadow": 0.9)",
          layer + R"(, "light": "scene", "shadow": 0.9, "clip_planes": [[0, 1, 0, 0.5]], "clip_upper": [0.6, 1, 1])",
          std::string(R"("level": 50, "width": 60, "preset": "mri")"),
          std::string(R"("level": 40, "width": 80, "color_map": "inferno", "opacity": 2)")})
        for (const bool shortcuts : {true, false}) {
            const Differences d = differences(o, shortcuts);
            EXPECT_LT(d.rms, 0.002) << o << shortcuts;
            EXPECT_LT(d.worst, 0.03) << o << shortcuts;
            EXPECT_GT(d.mean, 0.02) << o;
        }
}

TEST_F(DvrTwin, projections_are_the_greatest_and_the_mean_of_all_steps) {
    write(32, ball);
    for (const char* options :
         {R"(, "mode": "maximum")", R"(, "mode": "maximum", "clip_planes": [[0, 0.6, 0.8, 0.75]], "step": 0.6)",
          R"(, "mode": "average", "clip_lower": [0.25, 0.25, 0.25], "clip_upper": [0.75, 0.75, 0.75])",
          R"(, "mode": "average", "clip_lower": [0.3, 0.3, 0.3], "clip_upper": [0.8, 0.7, 0.7], "step": 0.5)"})
        for (const bool shortcuts : {true, false}) {
            const Differences d = differences(fmt::format("{}{}", layers, options), shortcuts);
            EXPECT_LT(d.rms, 0.004) << options << shortcuts;
            EXPECT_GT(d.mean, 0.02) << options;
        }
}

// At the outline a ray may cut off less than a step of the surface, which is missed.
TEST_F(DvrTwin, surfaces_stand_where_small_steps_find_them) {
    write(32, ball);
    for (const char* options :
         {R"(, "mode": "isosurface", "iso": 40)", R"(, "mode": "isosurface", "iso": 70, "step": 0.5)",
          R"(, "mode": "isosurface", "iso": 30, "clip_planes": [[0, 0.6, 0.8, 0.75]])",
          R"(, "mode": "isosurface", "iso": 30, "clip_upper": [0.6, 1, 1], "light": "scene")"})
        for (const bool shortcuts : {true, false}) {
            const Differences d = differences(fmt::format("{}{}", layers, options), shortcuts);
            EXPECT_LT(d.rms, 0.03) << options << shortcuts;
            EXPECT_GT(d.mean, 0.1) << options;
        }
}

}  // namespace
}  // namespace spinel::dvr_twin_test
