#include "formats/samples.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstring>

#include "core/parallel.h"
#include "formats/volume_scene.h"
#include "scene/validate.h"

namespace spinel {
namespace {

template <class T>
void decode(std::string_view bytes, bool swapped, double slope, double intercept, std::vector<float>& values) {
    parallel_for(values.size(), 1 << 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            unsigned char raw[sizeof(T)];
            std::memcpy(raw, bytes.data() + i * sizeof(T), sizeof(T));
            if (swapped)
                for (std::size_t k = 0; k < sizeof(T) / 2; ++k) std::swap(raw[k], raw[sizeof(T) - 1 - k]);
            T value;
            std::memcpy(&value, raw, sizeof(T));
            values[i] = float(slope * double(value) + intercept);
        }
    });
}

}  // namespace

std::size_t sample_bytes(SampleType type) {
    switch (type) {
        case SampleType::u8:
        case SampleType::i8: return 1;
        case SampleType::u16:
        case SampleType::i16: return 2;
        case SampleType::u32:
        case SampleType::i32:
        case SampleType::f32: return 4;
        case SampleType::u64:
        case SampleType::i64:
        case SampleType::f64: break;
    }
    return 8;
}

std::optional<std::uint64_t> bytes_of_samples(ivec3 size, SampleType type) {
    if (size.x < 1 || size.y < 1 || size.z < 1) return std::nullopt;
    const std::uint64_t layer = std::uint64_t(size.x) * std::uint64_t(size.y);
    if (layer > MAX_VOLUME_SAMPLES || layer * std::uint64_t(size.z) > MAX_VOLUME_SAMPLES) return std::nullopt;
    return layer * std::uint64_t(size.z) * sample_bytes(type);
}

DecodedSamples decode_samples(std::string_view bytes, SampleType type, bool big_endian, double slope,
                              double intercept) {
    const bool swapped = big_endian != (std::endian::native == std::endian::big);
    DecodedSamples result;
    result.values.resize(bytes.size() / sample_bytes(type));
    const auto run = [&]<class T>(T) { decode<T>(bytes, swapped, slope, intercept, result.values); };
    switch (type) {
        case SampleType::u8: run(std::uint8_t()); break;
        case SampleType::i8: run(std::int8_t()); break;
        case SampleType::u16: run(std::uint16_t()); break;
        case SampleType::i16: run(std::int16_t()); break;
        case SampleType::u32: run(std::uint32_t()); break;
        case SampleType::i32: run(std::int32_t()); break;
        case SampleType::u64: run(std::uint64_t()); break;
        case SampleType::i64: run(std::int64_t()); break;
        case SampleType::f32: run(float()); break;
        case SampleType::f64: run(double()); break;
    }
    for (float& value : result.values) {
        if (std::isfinite(value)) continue;
        value = 0;
        ++result.replaced;
    }
    return result;
}

mat4x3 patient_to_world(const mat4x3& ras) {
    mat4x3 world;
    for (int i = 0; i < 4; ++i) world[i] = vec3(ras[i].x, ras[i].z, -ras[i].y);
    return world;
}

Result<Scene> scan_scene(const std::string& name, ivec3 size, DecodedSamples samples, const mat4x3& index_to_local,
                         const std::string& unit) {
    Result<GridPointer> built = build_grid(size, samples.values);
    if (!built) return Error{"it " + built.error().message};
    if (const auto fault = transform_fault(index_to_local)) return Error{"it " + *fault};
    Grid grid;
    grid.name = name;
    grid.samples = *built;
    grid.index_to_local = index_to_local;
    grid.background = grid.samples->minimum();
    grid.unit = unit;
    const BareVolume look = look_of_scan(grid);
    Scene scene = volume_scene({std::move(grid)}, look);
    if (samples.replaced > 0)
        scene.notes.push_back(fmt::format("{} samples that are not finite are read as 0", samples.replaced));
    return scene;
}

}  // namespace spinel
