#include "scene/json_document.h"

#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>

namespace spinel {
namespace {

using Json = nlohmann::json;

constexpr std::size_t greatest_depth = 512;
constexpr std::size_t greatest_size = std::size_t(64) << 20;  // bytes of text

// Builds the tree from the events of nlohmann's parser. The parser does not say where a token begins, but it
// has checked the text, so a cursor that skips separators, comments and tokens keeps step with its events.
class TreeBuilder : public nlohmann::json_sax<Json> {
  public:
    explicit TreeBuilder(JsonDocument& document) : document_(document), text_(document.text) {
        if (text_.starts_with("\xEF\xBB\xBF")) cursor_ = 3;  // byte order mark
    }

    const std::optional<Error>& error() const { return error_; }

    bool null() override { return scalar(nullptr); }
    bool boolean(bool value) override { return scalar(value); }
    bool number_integer(number_integer_t value) override { return scalar(double(value)); }
    bool number_unsigned(number_unsigned_t value) override { return scalar(double(value)); }
    bool number_float(number_float_t value, const string_t&) override { return scalar(double(value)); }
    bool string(string_t& value) override {
        const std::size_t offset = skip_separators();
        skip_string();
        place(JsonValue{std::move(value), offset});
        return true;
    }
    bool binary(binary_t&) override { return false; }  // not in JSON text

    bool start_object(std::size_t) override { return open(JsonValue::Object{}); }
    bool start_array(std::size_t) override { return open(JsonValue::Array{}); }
    bool key(string_t& value) override {
        const std::size_t offset = skip_separators();
        skip_string();
        std::get<JsonValue::Object>(open_.back().data).push_back({std::move(value), offset, {}});
        return true;
    }
    bool end_object() override { return no_key_twice() && close(); }
    bool end_array() override { return close(); }

    bool parse_error(std::size_t position, const std::string& token, const Json::exception& exception) override {
        // nlohmann tells the last character read; better is where its token begins, if that is what stands
        // there.
        const std::size_t last = std::min(position - std::min(position, std::size_t(1)), text_.size());
        const std::size_t begin = skip_separators();
        const bool same = begin <= last && text_.find_first_of(" \t\r\n,:", begin) >= last;
        fail(same ? begin : last, sentence(exception, token));
        return false;
    }

  private:
    template <class T>
    bool scalar(T value) {
        const std::size_t offset = skip_separators();
        while (cursor_ < text_.size() && is_word(text_[cursor_])) ++cursor_;
        place(JsonValue{value, offset});
        return true;
    }

    template <class Container>
    bool open(Container container) {
        const std::size_t offset = skip_separators();
        ++cursor_;
        if (open_.size() == greatest_depth) {
            fail(offset, "nested more than " + std::to_string(greatest_depth) + " levels deep");
            return false;
        }
        open_.push_back(JsonValue{std::move(container), offset});
        return true;
    }

    bool close() {
        skip_separators();
        ++cursor_;
        JsonValue value = std::move(open_.back());
        open_.pop_back();
        place(std::move(value));
        return true;
    }

    void place(JsonValue value) {
        if (open_.empty()) document_.root = std::move(value);
        else if (auto* array = std::get_if<JsonValue::Array>(&open_.back().data)) array->push_back(std::move(value));
        else std::get<JsonValue::Object>(open_.back().data).back().value = std::move(value);
    }

    bool no_key_twice() {
        std::vector<const JsonMember*> members;
        for (const JsonMember& member : std::get<JsonValue::Object>(open_.back().data)) members.push_back(&member);
        std::stable_sort(members.begin(), members.end(), [](auto* a, auto* b) { return a->key < b->key; });
        const JsonMember* second = nullptr;
        for (std::size_t i = 1; i < members.size(); ++i)
            if (members[i]->key == members[i - 1]->key && (!second || members[i]->offset < second->offset))
                second = members[i];
        if (second) fail(second->offset, "key \"" + second->key + "\" stands twice in this object");
        return !second;
    }

    static bool is_word(char c) {
        return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || c == 'E' || c == '+' || c == '-' || c == '.';
    }

    // To the next token, whose offset it returns.
    std::size_t skip_separators() {
        while (cursor_ < text_.size()) {
            const char c = text_[cursor_];
            if (c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == ',' || c == ':') {
                ++cursor_;
            } else if (c == '/') {
                const bool line = text_.compare(cursor_, 2, "//") == 0;
                const std::size_t end = text_.find(line ? "\n" : "*/", cursor_ + 2);
                cursor_ = end == std::string::npos ? text_.size() : end + (line ? 1 : 2);
            } else {
                break;
            }
        }
        return cursor_;
    }

    void skip_string() {
        for (++cursor_; cursor_ < text_.size() && text_[cursor_] != '"'; ++cursor_)
            if (text_[cursor_] == '\\') ++cursor_;
        ++cursor_;
    }

    // The useful part of nlohmann's message.
    static std::string sentence(const Json::exception& exception, const std::string& token) {
        std::string what = exception.what();
        if (what.find("number overflow") != std::string::npos) return "number " + token + " is out of range";
        what = what.substr(0, what.find("; last read:"));  // may hold more than the token
        const std::size_t start = what.find("syntax error");
        if (start != std::string::npos) return what.substr(start);
        const std::size_t bracket = what.find("] ");
        return bracket == std::string::npos ? what : what.substr(bracket + 2);
    }

    void fail(std::size_t offset, const std::string& message) {
        if (!error_) error_ = document_.error(offset, message);
    }

    JsonDocument& document_;
    const std::string& text_;
    std::size_t cursor_ = 0;
    std::vector<JsonValue> open_;
    std::optional<Error> error_;
};

}  // namespace

const JsonValue* JsonValue::find(std::string_view key) const {
    if (const Object* members = object())
        for (const JsonMember& member : *members)
            if (member.key == key) return &member.value;
    return nullptr;
}

std::string JsonValue::description() const {
    if (is_null()) return "null";
    if (boolean()) return *boolean() ? "true" : "false";
    if (number()) return "a number";
    if (text()) return "the text \"" + (text()->size() > 40 ? text()->substr(0, 40) + "…" : *text()) + "\"";
    if (array()) return array()->empty() ? "an empty array" : "an array of " + std::to_string(array()->size());
    return "an object";
}

Error JsonDocument::error(std::size_t offset, std::string_view message) const {
    std::size_t line = 1, column = 1;
    for (std::size_t i = 0; i < std::min(offset, text.size()); ++i) {
        if (text[i] == '\n') ++line, column = 1;
        else if ((std::uint8_t(text[i]) & 0xC0) != 0x80)  // not the continuation of a code point
            ++column;
    }
    return Error{file + ":" + std::to_string(line) + ":" + std::to_string(column) + ": " + std::string(message)};
}

Result<JsonDocument> parse_json(std::string text, std::string file) {
    if (text.size() > greatest_size)
        return Error{file + ": " + std::to_string(text.size() >> 20) + " MiB of JSON; at most " +
                     std::to_string(greatest_size >> 20) + " MiB are read (keep large data in files of their own)"};
    JsonDocument document{std::move(file), std::move(text), {}};
    TreeBuilder builder(document);
    const bool strict = true, comments = true;
    const bool parsed = Json::sax_parse(document.text.begin(), document.text.end(), &builder,
                                        Json::input_format_t::json, strict, comments);
    if (builder.error()) return *builder.error();
    if (!parsed) return document.error(0, "not a JSON text");
    return document;
}

}  // namespace spinel
