#pragma once
// Numbers of scans as their files keep them: one type, either byte order, one after the other.

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "spinel/scene.h"

namespace spinel {

enum class SampleType { u8, i8, u16, i16, u32, i32, u64, i64, f32, f64 };

std::size_t sample_bytes(SampleType type);

// The bytes of `size` samples, if there are no more than are allowed.
std::optional<std::uint64_t> bytes_of_samples(ivec3 size, SampleType type);

// How many samples a volume may have, and bytes a file that unpacks to them.
constexpr std::uint64_t MAX_VOLUME_SAMPLES = std::uint64_t(1) << 31;
constexpr std::uint64_t MAX_VOLUME_BYTES = std::uint64_t(1) << 34;

struct DecodedSamples {
    std::vector<float> values;
    std::size_t replaced = 0;  // what is not finite is 0
};

// slope · sample + intercept, of as many samples as `bytes` holds.
DecodedSamples decode_samples(std::string_view bytes, SampleType type, bool big_endian, double slope = 1,
                              double intercept = 0);

// Axes of patients, x to the right, y to the front, z up (RAS), turned to +y up: (x, y, z) to (x, z, −y).
mat4x3 patient_to_world(const mat4x3& ras);

// One grid of a scan with its bare scene. `index_to_local` takes index space, where sample i sits at i + ½. The notes
// tell what was replaced.
Result<Scene> scan_scene(const std::string& name, ivec3 size, DecodedSamples samples, const mat4x3& index_to_local,
                         const std::string& unit);

}  // namespace spinel
