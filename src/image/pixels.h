#pragma once
// Pixels in memory, row 0 at the top.

#include <cstddef>
#include <cstdint>
#include <variant>
#include <vector>

namespace spinel {

// Either 8-bit (as stored, not decoded) or float pixels, channels interleaved.
struct PixelBuffer {
    int width = 0;
    int height = 0;
    int channels = 0;                                                  // 1 … 4
    std::variant<std::vector<std::uint8_t>, std::vector<float>> data;  // 8 bits a value; or more, integers as 0 … 1
    bool encoded = false;  // stored as integers: colours are sRGB-encoded, unless the picture is data
    std::size_t value_count() const { return std::size_t(width) * std::size_t(height) * std::size_t(channels); }
};

// A named plane of floats, as a film or an EXR layer holds it.
struct Image {
    int width = 0;
    int height = 0;
    int channels = 3;
    std::vector<float> values;
    float* at(int x, int y) {
        return values.data() + (std::size_t(y) * std::size_t(width) + std::size_t(x)) * std::size_t(channels);
    }
    const float* at(int x, int y) const { return const_cast<Image*>(this)->at(x, y); }
};

}  // namespace spinel
