#pragma once
// Writes NBT for the tests of its readers: a tag is its type, and what follows its name.

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "formats/nbt.h"

namespace spinel::nbt {

template <class T>
std::string big_endian(T value) {
    std::string bytes;
    for (int i = int(sizeof(T)) - 1; i >= 0; --i) bytes += char(std::uint64_t(value) >> (8 * i));
    return bytes;
}

struct Written {
    Type type;
    std::string payload;
};
using Members = std::vector<std::pair<std::string, Written>>;

inline std::string counted(const std::string& s) { return big_endian(std::uint16_t(s.size())) + s; }
inline Written int8(int v) { return {Type::int8, big_endian(std::int8_t(v))}; }
inline Written int16(int v) { return {Type::int16, big_endian(std::int16_t(v))}; }
inline Written int32(int v) { return {Type::int32, big_endian(std::int32_t(v))}; }
inline Written text(const std::string& s) { return {Type::string, counted(s)}; }
inline Written bytes(const std::string& s) { return {Type::int8_array, big_endian(std::int32_t(s.size())) + s}; }
inline Written longs(const std::vector<std::uint64_t>& values) {
    std::string payload = big_endian(std::int32_t(values.size()));
    for (const std::uint64_t value : values) payload += big_endian(value);
    return {Type::int64_array, payload};
}
inline Written list(Type type, const std::vector<Written>& items) {
    std::string payload = char(type) + big_endian(std::int32_t(items.size()));
    for (const Written& item : items) payload += item.payload;
    return {Type::list, payload};
}
inline Written compound(const Members& members) {
    std::string payload;
    for (const auto& [name, tag] : members) payload += char(tag.type) + counted(name) + tag.payload;
    return {Type::compound, payload + '\0'};
}
inline std::string document(const Members& members) {
    return char(Type::compound) + counted("") + compound(members).payload;
}
inline Written ints(const std::vector<int>& values) {
    std::vector<Written> items;
    for (const int value : values) items.push_back(int32(value));
    return list(Type::int32, items);
}

// Indices of `bits` bits in words, spanning them or not.
inline std::vector<std::uint64_t> packed(const std::vector<unsigned>& indices, unsigned bits, bool spanning) {
    std::vector<std::uint64_t> words;
    std::size_t used = 64;  // of the last word
    for (const std::uint64_t index : indices) {
        if (used >= 64 || (!spanning && used + bits > 64)) {
            words.push_back(0);
            used = used >= 64 && spanning ? used - 64 : 0;
        }
        words.back() |= index << used;
        if (used + bits > 64) {
            words.push_back(index >> (64 - used));
            used = used + bits - 64;
        } else {
            used += bits;
        }
    }
    return words;
}

}  // namespace spinel::nbt
