#pragma once
// Reads little-endian binary data with every access checked. The first access beyond the end makes the reader
// fail, and from then on it gives zeros: a parser may read a whole record and ask ok() once. Loops must still
// check their counts against remaining().

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
    std::uint32_t u32() { return number<std::uint32_t>(); }
    std::int32_t i32() { return number<std::int32_t>(); }
    float f32() { return number<float>(); }

  private:
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
