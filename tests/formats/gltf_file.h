#pragma once
// glTF files for the tests: one triangle, whose nodes and materials a test writes.

#include "image/image_io.h"
#include "test_files.h"

namespace spinel {

inline std::string base64(const std::string& bytes) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string result;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t word = 0;
        for (std::size_t k = 0; k < 3; ++k) word = word << 8 | (i + k < bytes.size() ? std::uint8_t(bytes[i + k]) : 0u);
        for (std::size_t k = 0; k < 4; ++k) result += i + k > bytes.size() ? '=' : digits[word >> (18 - 6 * k) & 63];
    }
    return result;
}

class GltfTest : public FileTest {
  protected:
    // A glTF of one triangle (0,0,0) (1,0,0) (0,1,0) with two sets of uvs, the second twice the first; `nodes`,
    // `materials` and the rest are JSON text.
    std::filesystem::path gltf(const std::string& nodes, const std::string& materials, const std::string& more = "") {
        std::string data;
        for (const float f : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f}) data += raw(f);  // positions
        for (int i = 0; i < 3; ++i)
            for (const float f : {0.f, 0.f, 1.f}) data += raw(f);             // normals
        for (const float f : {0.f, 1.f, 1.f, 1.f, 0.f, 0.f}) data += raw(f);  // uvs, v down
        for (const float f : {0.f, 2.f, 2.f, 2.f, 0.f, 0.f}) data += raw(f);
        return write("a.gltf", R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
            "buffers": [{"byteLength": 120, "uri": "data:application/octet-stream;base64,)" +
                                   base64(data) + R"("}],
            "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 36},
                            {"buffer": 0, "byteOffset": 72, "byteLength": 24}, {"buffer": 0, "byteOffset": 96, "byteLength": 24}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0,0,0], "max": [1,1,0]},
                          {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC3"},
                          {"bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC2"},
                          {"bufferView": 3, "componentType": 5126, "count": 3, "type": "VEC2"}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2, "TEXCOORD_1": 3}, "material": 0}]}],
            "nodes": )" + nodes + R"(, "materials": )" +
                                   materials + more + "}");
    }
    void write_png(const std::string& name, const Image& image, const std::vector<std::string>& channels) {
        const Result<void> written = write_image(folder / name, {{channels, image}});
        ASSERT_TRUE(written) << written.error().message;
    }
};

}  // namespace spinel
