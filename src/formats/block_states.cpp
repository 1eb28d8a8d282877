#include "formats/block_states.h"

#include <bit>

namespace spinel {

std::string state_text(const nbt::Tag& entry) {
    std::string text(entry.string_of("Name"));
    const nbt::Tag* properties = entry.find("Properties", nbt::Type::compound);
    if (!properties || properties->children.empty()) return text;
    char separator = '[';
    for (const nbt::Tag& property : properties->children) {
        text += separator + std::string(property.name) + "=" + std::string(property.bytes);
        separator = ',';
    }
    return text + "]";
}

Result<std::vector<std::uint32_t>> read_palette(const nbt::Tag& list, BlockScene& scene) {
    std::vector<std::uint32_t> states;
    for (const nbt::Tag& entry : list.children) {
        if (entry.string_of("Name").empty()) return Error{"a palette entry has no Name"};
        states.push_back(scene.state(state_text(entry)));
    }
    return states;
}

int bits_for(std::size_t count, int least) { return std::max(least, count < 2 ? 0 : int(std::bit_width(count - 1))); }

PackedIndices::PackedIndices(const nbt::Tag& words, int bits, bool spanning) : bits_(bits), spanning_(spanning) {
    words_.resize(words.count());
    for (std::size_t i = 0; i < words_.size(); ++i) words_[i] = std::uint64_t(words.element(i));
}

std::size_t PackedIndices::operator[](std::size_t i) const {
    const std::uint64_t mask = (std::uint64_t(1) << bits_) - 1;
    if (!spanning_) {
        const std::size_t per_word = 64 / std::size_t(bits_);
        return words_[i / per_word] >> (i % per_word * std::size_t(bits_)) & mask;
    }
    const std::size_t bit = i * std::size_t(bits_), word = bit / 64, shift = bit % 64;
    std::uint64_t value = words_[word] >> shift;
    if (shift + std::size_t(bits_) > 64) value |= words_[word + 1] << (64 - shift);
    return value & mask;
}

std::size_t PackedIndices::words_for(std::size_t count, int bits, bool spanning) {
    if (spanning) return (count * std::size_t(bits) + 63) / 64;
    const std::size_t per_word = 64 / std::size_t(bits);
    return (count + per_word - 1) / per_word;
}

}  // namespace spinel
