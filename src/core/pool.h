#pragma once
// Arrays that records of kernels refer into by 32-bit indices, of which the last stands for "none".

#include <cstdint>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"

namespace spinel {

constexpr std::size_t max_pool = 0xffffffffu;

// Where `more` elements begin that are appended to `size`: their first index. `what` there would be too many of.
inline Result<std::uint32_t> pool_place(std::size_t size, std::size_t more, std::string_view what) {
    if (size <= max_pool && more <= max_pool - size) return std::uint32_t(size);
    return Error{"the scene needs more than the " + std::to_string(max_pool) + " " + std::string(what) +
                 " that can be addressed"};
}

// The index of the first of the elements appended.
template <class T, class Allocator, class Range>
Result<std::uint32_t> append_pool(std::vector<T, Allocator>& pool, const Range& more, std::string_view what) {
    Result<std::uint32_t> first = pool_place(pool.size(), std::size(more), what);
    if (first) pool.insert(pool.end(), std::begin(more), std::end(more));
    return first;
}

}  // namespace spinel
