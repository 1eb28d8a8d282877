// SDF geometries of the scene file. An expression is text, or a tree of objects: "op" names the operation,
// further keys are its parameters, "args" lists its children.

#include <algorithm>

#include "geometry/sdf/sdf_ops.h"
#include "geometry/sdf/sdf_text.h"
#include "scene/json_context.h"

namespace spinel {
namespace {

SdfNode read_node(JsonContext& context, const JsonValue& value, const std::string& what) {
    SdfNode node;
    if (!value.object()) {
        context.json.fail(value, "an SDF node of " + what + " must be an object, not " + value.description());
        return node;
    }
    const JsonValue* op = value.find("op");
    if (!op) {
        context.json.fail(value, "an SDF node of " + what + " needs \"op\"");
        return node;
    }
    node.op = context.json.text(*op, "\"op\" of " + what).value_or("");
    const SdfOperation* operation = find_sdf_operation(node.op);
    if (!operation) {
        context.json.fail(*op, unknown_sdf_operation(node.op) + " (in " + what + ")");
        return node;
    }
    const std::string where = "\"" + node.op + "\" in " + what;

    std::vector<std::string> allowed = {"op"};
    for (const SdfParameter& parameter : operation->parameters) allowed.emplace_back(parameter.name);
    if (operation->child_maximum > 0) allowed.push_back("args");
    for (const JsonMember& member : *value.object())
        if (std::find(allowed.begin(), allowed.end(), member.key) == allowed.end())
            context.json.fail(member.offset,
                              "unknown key \"" + member.key + "\" of " + where + "; allowed: " + list_names(allowed));

    for (const SdfParameter& parameter : operation->parameters) {
        const std::string name(parameter.name);
        const JsonValue* given = value.find(name);
        if (!given && !parameter.fallback) context.json.fail(value, where + " needs \"" + name + "\"");
        const Range range{parameter.minimum, parameter.maximum};
        float number = parameter.fallback.value_or(0);
        if (given) number = float(context.json.number(*given, range, "\"" + name + "\" of " + where).value_or(number));
        node.numbers.push_back(number);
    }
    if (context.json.error()) return node;
    if (const auto complete = complete_sdf_numbers(*operation, node.numbers); !complete) {
        context.json.fail(value, complete.error().message);
        return node;
    }

    if (const JsonValue* args = value.find("args"))
        context.json.elements(*args, "\"args\" of " + where, [&](const JsonValue& child, std::size_t) {
            node.children.push_back(read_node(context, child, what));
        });
    if (const auto f = sdf_child_fault(*operation, node.children.size())) context.json.fail(value, *f);
    return node;
}

}  // namespace

SdfGeometry read_sdf(JsonContext& context, const JsonValue& value, const std::string& what) {
    SdfGeometry sdf;
    if (const JsonValue* expression = value.find("expression")) {
        if (expression->text()) {
            Result<SdfNode> root = parse_sdf_text(*expression->text(), "\"expression\" of " + what);
            if (root) sdf.root = *std::move(root);
            else context.json.fail(*expression, root.error().message);
        } else if (expression->object()) {
            sdf.root = read_node(context, *expression, what);
        } else {
            context.json.fail(*expression, "\"expression\" of " + what +
                                               " must be a text or an object with \"op\", not " +
                                               expression->description());
        }
    }
    if (const JsonValue* bounds = value.find("bounds")) {
        const std::string where = "\"bounds\" of " + what;
        if (!bounds->array() || bounds->array()->size() != 2) {
            context.json.fail(*bounds, where + " must be an array of 2 corners, not " + bounds->description());
            return sdf;
        }
        const auto lower = context.json.triple((*bounds->array())[0], any, where);
        const auto upper = context.json.triple((*bounds->array())[1], any, where);
        if (lower && upper) sdf.bounds = std::pair(*lower, *upper);
    }
    return sdf;
}

}  // namespace spinel
