#include "scene/integrator_setting.h"

#include "scene/json_fields.h"

namespace spinel {

Result<void> set_integrator(IntegratorSettings& settings, const std::string& assignment) {
    const std::size_t equals = assignment.find('=');
    const std::string key = assignment.substr(0, equals);
    const Record& record = integrator_record();
    std::vector<std::string> keys;
    bool known = false;
    for (const Field& field : record.fields) {
        if (field.kind == FieldKind::text) continue;  // its name has an option of its own
        keys.emplace_back(field.name);
        known |= field.name == key;
    }
    if (equals == std::string::npos || !known)
        return Error{"--set '" + assignment + "': expected KEY=NUMBER, KEY being one of " + list_names(keys)};
    const Result<JsonDocument> document = parse_json(assignment.substr(equals + 1), "--set");
    if (!document) return Error{"--set '" + assignment + "': the value is not a number"};
    JsonReader reader(*document);
    reader.field(document->root, *record.find(key), &settings, "integrator");
    if (!reader.error()) return {};
    // "--set:1:1: message": the place says nothing here.
    const std::string& message = reader.error()->message;
    return Error{"--set '" + assignment + "': " + message.substr(message.find(": ") + 2)};
}

}  // namespace spinel
