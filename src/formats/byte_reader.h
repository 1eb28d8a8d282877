#pragma once
// Reads binary data with every access checked; numbers are little-endian unless their name ends in _be. The first
// access beyond the end makes the reader fail, and from then on it gives zeros: a parser may read a whole record and
// ask ok() once. Loops must still check their counts against remaining().

#include <bit>
#include <cstdint>
#include <cstring>
#include <string_view>

namespace spinel {

class ByteReader {
  public:
    // `origin` is the position of the first byte within the file, so that offset() can be told to the user.
    explicit ByteReader(std::string_view bytes, std::size_t origin = 0) : bytes_(bytes), origin_(origin) {}

    bool ok() const { return ok_; }
    std::size_t offset() const { return origin_ + position_; }
    std::size_t remaining() const { return bytes_.size() - position_; }

    std::string_view take(std::size_t count) {
        if (!ok_ || count > remaining()) {
            ok_ = false;
            return {};
        }
        const std::string_view taken = bytes_.substr(position_, count);
        position_ += count;
        return taken;
    }
    std::uint8_t u8() { return number<std::uint8_t>(); }
    std::uint16_t u16() { return number<std::uint16_t>(); }
    std::uint32_t u32() { return number<std::uint32_t>(); }
    std::int32_t i32() { return number<std::int32_t>(); }
    float f32() { return number<float>(); }
    std::uint16_t u16_be() { return std::uint16_t(big_endian(2)); }
    std::uint32_t u32_be() { return std::uint32_t(big_endian(4)); }
    std::uint64_t u64_be() { return big_endian(8); }

  private:
    std::uint64_t big_endian(std::size_t count) {
        std::uint64_t value = 0;
        for (const char byte : take(count)) value = value << 8 | std::uint8_t(byte);
        return value;
    }
    template <class T>
    T number() {
        static_assert(std::endian::native == std::endian::little, "file data is used as it lies in the file");
        T value{};
        const std::string_view raw = take(sizeof(T));
        if (!raw.empty()) std::memcpy(&value, raw.data(), sizeof(T));
        return value;
    }
    std::string_view bytes_;
    std::size_t origin_;
    std::size_t position_ = 0;
    bool ok_ = true;
};

}  // namespace spinel
