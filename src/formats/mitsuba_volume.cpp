#include "formats/mitsuba_volume.h"

#include <fmt/format.h>

#include <cmath>

#include "formats/byte_reader.h"
#include "formats/file_bytes.h"
#include "formats/samples.h"
#include "formats/volume_scene.h"
#include "kernels/portable.h"
#include "scene/validate.h"

namespace spinel {
namespace {

enum Encoding : std::int32_t { FLOATS = 1, HALVES = 2, BYTES = 3 };

Result<Scene> read_mitsuba(std::string_view bytes, const std::string& name) {
    ByteReader reader(bytes);
    if (reader.take(3) != "VOL") return Error{"it is not a volume of Mitsuba"};
    if (const int version = reader.u8(); version != 3)
        return Error{fmt::format("it is of version {} of the format; readable is 3", version)};
    const std::int32_t encoding = reader.i32();
    if (encoding != FLOATS && encoding != HALVES && encoding != BYTES)
        return Error{fmt::format("its encoding is {}; readable are 1 (floats), 2 (halves) and 3 (bytes)", encoding)};
    ivec3 size(0);
    for (int i = 0; i < 3; ++i) size[i] = reader.i32();
    const std::int32_t channels = reader.i32();
    vec3 lower(0), upper(0);
    for (int i = 0; i < 3; ++i) lower[i] = reader.f32();
    for (int i = 0; i < 3; ++i) upper[i] = reader.f32();
    if (!reader.ok()) return Error{"it is cut off"};
    if (channels != 1 && channels != 3) return Error{fmt::format("it has {} channels; 1 or 3 are allowed", channels)};
    const SampleType type = encoding == FLOATS   ? SampleType::f32
                            : encoding == HALVES ? SampleType::u16
                                                 : SampleType::u8;
    const auto wanted = bytes_of_samples(size, type);
    if (!wanted)
        return Error{fmt::format("its size is {}×{}×{}; up to {} samples are allowed", size.x, size.y, size.z,
                                 MAX_VOLUME_SAMPLES)};
    if (reader.remaining() < *wanted * std::uint64_t(channels))
        return Error{fmt::format("its size needs {} bytes of samples, there are {}", *wanted * std::uint64_t(channels),
                                 reader.remaining())};
    DecodedSamples samples =
        decode_samples(reader.take(*wanted * std::size_t(channels)), type, false, encoding == BYTES ? 1.0 / 255 : 1.0);
    if (encoding == HALVES)
        for (float& v : samples.values) {
            v = kernels::half_float(kernels::uint(v));
            if (!std::isfinite(v)) v = 0, ++samples.replaced;
        }
    Result<GridPointer> built = build_grid(size, samples.values, channels);
    if (!built) return Error{"it " + built.error().message};
    const vec3 edge = (upper - lower) / vec3(size);
    Grid grid;
    grid.name = name;
    grid.samples = *built;
    grid.index_to_local = mat4x3(vec3(edge.x, 0, 0), vec3(0, edge.y, 0), vec3(0, 0, edge.z), lower);
    if (const auto fault = transform_fault(grid.index_to_local)) return Error{"its box " + *fault};
    Scene scene = volume_scene({std::move(grid)});
    if (samples.replaced > 0)
        scene.notes.push_back(fmt::format("{} samples that are not finite are read as 0", samples.replaced));
    return scene;
}

}  // namespace

Result<Scene> load_mitsuba_volume(const std::filesystem::path& path, const LoadOptions&) {
    const Result<std::string> bytes = read_file_bytes(path, MAX_VOLUME_BYTES);
    if (!bytes) return bytes.error();
    Result<Scene> scene = read_mitsuba(*bytes, path.stem().string());
    return scene ? std::move(scene) : Result<Scene>(cannot_read(path, scene.error().message));
}

}  // namespace spinel
