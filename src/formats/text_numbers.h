#pragma once
// Numbers in the text headers of other people's files.

#include <charconv>
#include <optional>
#include <string_view>
#include <vector>

namespace spinel {

// All of `text` as numbers with spaces between; nothing if there is anything else, or more than `most` of them.
template <class T>
std::optional<std::vector<T>> text_numbers(std::string_view text, std::size_t most = 64) {
    std::vector<T> result;
    const char* at = text.data();
    const char* end = at + text.size();
    while (true) {
        while (at < end && (*at == ' ' || *at == '\t')) ++at;
        if (at == end) return result;
        if (*at == '+') ++at;
        T value{};
        const auto [next, error] = std::from_chars(at, end, value);
        if (error != std::errc() || (next < end && *next != ' ' && *next != '\t') || result.size() == most)
            return std::nullopt;
        result.push_back(value);
        at = next;
    }
}

inline std::string_view trimmed(std::string_view text) {
    const auto first = text.find_first_not_of(" \t\r");
    return first == text.npos ? std::string_view() : text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

}  // namespace spinel
