// The same kernel headers, compiled as C++ and as SPIR-V, give the same answers.
//
// Integers are equal. Numbers agree to a tolerance, since the two compilers contract products and sums
// differently and Vulkan lets a device divide with 2.5 ulp of error and take sines with an absolute error of
// 2^-11. A decision (hit or miss) may differ only for a ray within rounding of an edge: at most one in a
// thousand, and none on a good day.
//
// Materials are those of the table in kernels/materials.h, each by value and by sample. Where a lobe is narrow the
// rounding of a half vector, 1e-7, is divided by its width, α ≥ 1e-3 (GGX_ALPHA_DELTA), and next to an index of 1,
// where wo + η wi nearly cancels, by that sum: hence 1e-3; samples come from sines besides.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ostream>
#include <string>
#include <vector>

#include "vulkan/case_scene.h"
#include "vulkan/kernel_cases.h"
#include "vulkan_test.h"

namespace spinel::kernels_agree_test {
namespace {

using kernels::CaseResult;
static_assert(sizeof(CaseResult) == 48, "scalar layout: the shader's struct is the host's");

constexpr uint32_t local_size = 64;  // of kernel_cases.comp
constexpr uint32_t all_cases = 20'000;

struct PushConstants {
    uint64_t results;
    uint64_t scenes;
    uint32_t count;
    uint32_t unused = 0;  // C++ would pad to the alignment of an address
};

struct Kind {
    const char* name;
    uint32_t kind;
    float tolerance;  // absolute below 1, relative above
    uint32_t count = all_cases;
};
void PrintTo(const Kind& kind, std::ostream* out) { *out << kind.name; }

class KernelsAgree : public testing::TestWithParam<Kind> {};

TEST_P(KernelsAgree, on_the_device_and_in_cpp) {
    auto device = open_vulkan_device();
    if (!device) return;
    const Kind kind = GetParam();
    const Result<CompiledScene> scene = make_case_scene();
    ASSERT_TRUE(scene) << scene.error().message;
    const auto there = DeviceScene::upload(*device, *scene);
    ASSERT_TRUE(there) << there.error().message;
    auto pipeline = device->create_pipeline(load_spirv("kernel_cases"), sizeof(PushConstants), {{kind.kind}});
    ASSERT_TRUE(pipeline) << pipeline.error().message;
    const std::vector<CaseResult> cleared(kind.count, CaseResult{glm::uvec4(~0u), glm::vec4(NAN), glm::vec4(NAN)});
    auto buffer = device->create_buffer<CaseResult>(cleared);
    ASSERT_TRUE(buffer) << buffer.error().message;
    auto done = device->run(*pipeline, PushConstants{buffer->address(), there->view(), kind.count},
                            {(kind.count + local_size - 1) / local_size, 1, 1});
    ASSERT_TRUE(done) << done.error().message;
    auto results = device->read<CaseResult>(*buffer);
    ASSERT_TRUE(results) << results.error().message;
    const kernels::SceneView view = scene->view();

    int flips = 0;
    float worst = 0.0f;
    for (uint32_t i = 0; i < kind.count; ++i) {
        const CaseResult expected = kernels::kernel_case(view, kind.kind, i);
        const CaseResult& actual = (*results)[i];
        if (actual.exact != expected.exact) {
            ASSERT_NE(kind.kind, kernels::CASE_RANDOM) << "case " << i;
            ASSERT_LE(++flips, int(kind.count / 1000)) << "decisions differ in too many cases, lastly in case " << i;
            continue;
        }
        for (int k = 0; k < 8; ++k) {
            const float a = k < 4 ? actual.a[k] : actual.b[k - 4];
            const float e = k < 4 ? expected.a[k] : expected.b[k - 4];
            const float error = std::abs(a - e) / std::max(1.0f, std::abs(e));
            // Written so that NaN on either side fails.
            ASSERT_TRUE(error <= kind.tolerance) << kind.name << " case " << i << " number " << k << ": " << a << " on "
                                                 << device->name() << ", " << e << " in C++";
            worst = std::max(worst, error);
        }
    }
    RecordProperty("worst_error", std::to_string(worst));
    RecordProperty("decisions_that_differ", flips);
}

#define SPINEL_MATERIAL_KINDS(number, CONSTANT, name)                  \
    Kind{#name "_value", kernels::CASE_MATERIAL + 2u * number, 1e-3f}, \
        Kind{#name "_sample", kernels::CASE_MATERIAL + 2u * number + 1u, 3e-3f},
constexpr Kind materials[] = {SPINEL_MATERIALS(SPINEL_MATERIAL_KINDS)};
#undef SPINEL_MATERIAL_KINDS

std::string name_of(const testing::TestParamInfo<Kind>& info) { return info.param.name; }

INSTANTIATE_TEST_SUITE_P(
    Kernels, KernelsAgree,
    testing::Values(Kind{"random", kernels::CASE_RANDOM, 0.0f}, Kind{"warp", kernels::CASE_WARP, 1e-3f},
                    Kind{"box", kernels::CASE_BOX, 3e-5f}, Kind{"triangle", kernels::CASE_TRIANGLE, 3e-5f},
                    Kind{"sphere", kernels::CASE_SPHERE, 3e-5f}, Kind{"microfacet", kernels::CASE_MICROFACET, 3e-3f},
                    Kind{"phase", kernels::CASE_PHASE, 3e-3f}, Kind{"noise", kernels::CASE_NOISE, 1e-4f},
                    Kind{"density", kernels::CASE_DENSITY, 1e-4f}, Kind{"sky", kernels::CASE_SKY, 1e-3f, 1000},
                    Kind{"sdf", kernels::CASE_SDF, 1e-3f}, Kind{"voxels", kernels::CASE_VOXELS, 1e-4f},
                    Kind{"scene", kernels::CASE_SCENE, 1e-4f}, Kind{"occluded", kernels::CASE_OCCLUDED, 0.0f},
                    Kind{"transmittance", kernels::CASE_TRANSMITTANCE, 1e-4f}),
    name_of);
INSTANTIATE_TEST_SUITE_P(Materials, KernelsAgree, testing::ValuesIn(materials), name_of);

}  // namespace
}  // namespace spinel::kernels_agree_test
