#include "scene/animation.h"

#include <fmt/format.h>
#include <charconv>

#include "scene/expression.h"
#include "scene/json_fields.h"

namespace spinel {
namespace {

constexpr double default_fps = 30;

class Animation {
  public:
    Animation(JsonDocument& document, const JsonValue& section) : document_(document), section_(section) {}

    Result<void> apply(const Moment& moment) {
        JsonReader reader(document_);
        reader.record(section_, animation_record(), nullptr, "animation");
        if (reader.error()) return *reader.error();
        double fps = default_fps;
        if (const JsonValue* given = section_.find("fps")) {
            fps = reader.number(*given, {1e-6, 1e6}, "\"fps\" of animation").value_or(fps);
            if (reader.error()) return *reader.error();
        }
        if (moment.fps > 0) fps = moment.fps;
        const double frame = moment.frame.value_or(0);
        variables_ = {{"t", frame / fps}, {"frame", frame}};
        if (const JsonValue* given = section_.find("variables"))
            if (Result<void> done = add_variables(*given); !done) return done;
        const JsonValue* values = section_.find("values");
        if (!values) return {};
        if (!values->object())
            return error(*values, "\"values\" of animation must be an object of places and formulas, not " +
                                      values->description());
        // Places are looked up in the text as it was written; no formula sees what another one gives.
        for (const JsonMember& member : *values->object()) {
            Result<JsonValue*> target = place(member);
            if (!target) return target.error();
            Result<JsonValue> value = evaluate(member.value, 0);
            if (!value) return value.error();
            **target = std::move(*value);
        }
        return {};
    }

  private:
    Error error(const JsonValue& at, const std::string& message) const { return document_.error(at.offset, message); }

    Result<double> number(const JsonValue& value) const {
        if (value.number()) return *value.number();
        if (!value.text()) return error(value, "expected a number or a formula, not " + value.description());
        const auto result = evaluate_expression(*value.text(), variables_);
        if (const auto* fault = std::get_if<ExpressionFault>(&result))
            return document_.error(value.offset + 1 + fault->position,
                                   "in \"" + *value.text() + "\": " + fault->message);
        return std::get<double>(result);
    }

    Result<void> add_variables(const JsonValue& value) {
        if (!value.object())
            return error(value, "\"variables\" of animation must be an object of names and formulas, not " +
                                    value.description());
        for (const JsonMember& member : *value.object()) {
            if (!is_variable_name(member.key) || variables_.contains(member.key))
                return document_.error(member.offset,
                                       "\"" + member.key +
                                           "\" cannot be the name of a variable: a letter, then letters, "
                                           "digits and _, and not a name that there is already");
            const Result<double> x = number(member.value);
            if (!x) return x.error();
            variables_[member.key] = *x;
        }
        return {};
    }

    // A number, a formula, or a list of these.
    Result<JsonValue> evaluate(const JsonValue& value, int depth) const {
        JsonValue out;
        out.offset = value.offset;
        if (const auto* array = value.array(); array && depth < 8) {
            JsonValue::Array elements;
            for (const JsonValue& element : *array) {
                Result<JsonValue> one = evaluate(element, depth + 1);
                if (!one) return one;
                elements.push_back(std::move(*one));
            }
            out.data = std::move(elements);
            return out;
        }
        const Result<double> x = number(value);
        if (!x) return x.error();
        out.data = *x;
        return out;
    }

    // "/lights/lamp/position/0": keys of objects, places in lists from 0, or the "name" of what stands in a list.
    Result<JsonValue*> place(const JsonMember& member) const {
        const std::string& path = member.key;
        const auto fail = [&](const std::string& message) {
            return document_.error(member.offset, "\"" + path + "\" of animation: " + message);
        };
        if (path.empty() || path[0] != '/') return fail("a place begins with /, as /camera/from/0");
        JsonValue* at = &document_.root;
        std::string so_far;
        for (std::size_t begin = 1; begin <= path.size();) {
            const std::size_t end = std::min(path.find('/', begin), path.size());
            const std::string key = path.substr(begin, end - begin);
            begin = end + 1;
            if (so_far.empty() && key == "animation") return fail("animation does not animate itself");
            at = step(*at, key);
            so_far += "/" + key;
            if (!at) return fail("there is no " + so_far + " in the scene; write its value at rest there");
        }
        return at;
    }

    static JsonValue* step(JsonValue& at, const std::string& key) {
        if (auto* object = std::get_if<JsonValue::Object>(&at.data)) {
            for (JsonMember& member : *object)
                if (member.key == key) return &member.value;
            return nullptr;
        }
        auto* array = std::get_if<JsonValue::Array>(&at.data);
        if (!array) return nullptr;
        for (JsonValue& element : *array)
            if (const JsonValue* name = element.find("name"); name && name->text() && *name->text() == key)
                return &element;
        std::size_t index = 0;
        const auto [end, error] = std::from_chars(key.data(), key.data() + key.size(), index);
        if (error != std::errc() || end != key.data() + key.size() || index >= array->size()) return nullptr;
        return &(*array)[index];
    }

    JsonDocument& document_;
    const JsonValue& section_;
    Variables variables_;
};

}  // namespace

Result<void> apply_animation(JsonDocument& document, const Moment& moment) {
    const JsonValue* section = document.root.find("animation");
    if (!section) {
        if (!moment.frame && !(moment.fps > 0)) return {};
        return Error{fmt::format("{}: {} asked for, but the scene has no \"animation\"", document.file,
                                 moment.frame ? "a frame is" : "frames a second are")};
    }
    // A copy: writing values may not move what is being read.
    const JsonValue copy = *section;
    return Animation(document, copy).apply(moment);
}

}  // namespace spinel
