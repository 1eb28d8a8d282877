// The same kernel headers, compiled as C++ and as SPIR-V, give the same answers.
//
// Integers are equal. Numbers agree to a tolerance, since the two compilers contract products and sums
// differently and Vulkan lets a device divide with 2.5 ulp of error and take sines with an absolute error of
// 2^-11. A decision (hit or miss) may differ only for a ray within rounding of an edge: at most one in a
// thousand, and none on a good day.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ostream>
#include <string>
#include <vector>

#include "vulkan/kernel_cases.h"
#include "vulkan_test.h"

namespace spinel {
namespace {

using kernels::CaseResult;
static_assert(sizeof(CaseResult) == 48, "scalar layout: the shader's struct is the host's");

constexpr uint32_t local_size = 64;  // of kernel_cases.comp
constexpr uint32_t case_count = 20'000;
constexpr int allowed_flips = case_count / 1000;

struct PushConstants {
    uint64_t results;
    uint32_t kind;
    uint32_t count;
};

struct Kind {
    const char* name;
    uint32_t kind;
    float tolerance;  // absolute below 1, relative above
};
void PrintTo(const Kind& kind, std::ostream* out) { *out << kind.name; }

class KernelsAgree : public testing::TestWithParam<Kind> {};

TEST_P(KernelsAgree, on_the_device_and_in_cpp) {
    auto device = open_vulkan_device();
    if (!device) return;
    auto pipeline = device->create_pipeline(load_spirv("kernel_cases"), sizeof(PushConstants));
    ASSERT_TRUE(pipeline) << pipeline.error().message;
    const std::vector<CaseResult> cleared(case_count, CaseResult{glm::uvec4(~0u), glm::vec4(NAN), glm::vec4(NAN)});
    auto buffer = device->create_buffer<CaseResult>(cleared);
    ASSERT_TRUE(buffer) << buffer.error().message;
    const Kind kind = GetParam();
    auto done = device->run(*pipeline, PushConstants{buffer->address(), kind.kind, case_count},
                            {(case_count + local_size - 1) / local_size, 1, 1});
    ASSERT_TRUE(done) << done.error().message;
    auto results = device->read<CaseResult>(*buffer);
    ASSERT_TRUE(results) << results.error().message;

    int flips = 0;
    float worst = 0.0f;
    for (uint32_t i = 0; i < case_count; ++i) {
        const CaseResult expected = kernels::kernel_case(kind.kind, i);
        const CaseResult& actual = (*results)[i];
        if (actual.exact != expected.exact) {
            ASSERT_NE(kind.kind, kernels::CASE_RANDOM) << "case " << i;
            ASSERT_LE(++flips, allowed_flips) << "decisions differ in too many cases, lastly in case " << i;
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

INSTANTIATE_TEST_SUITE_P(Kernels, KernelsAgree,
                         testing::Values(Kind{"random", kernels::CASE_RANDOM, 0.0f},
                                         Kind{"warp", kernels::CASE_WARP, 1e-3f}, Kind{"box", kernels::CASE_BOX, 3e-5f},
                                         Kind{"triangle", kernels::CASE_TRIANGLE, 3e-5f},
                                         Kind{"sphere", kernels::CASE_SPHERE, 3e-5f},
                                         Kind{"microfacet", kernels::CASE_MICROFACET, 3e-3f},
                                         Kind{"scatter", kernels::CASE_SCATTER, 3e-3f}),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace spinel
