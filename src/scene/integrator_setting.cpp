#include "scene/integrator_setting.h"

#include "scene/json_fields.h"

namespace spinel {

Result<void> set_integrator(IntegratorSettings& settings, const std::string& assignment) {
    const std::size_t equals = assignment.find('=');
    const std::string key = assignment.substr(0, equals);
    // "march.step": a record of its own within the integrator.
    const std::size_t dot = key.find('.');
    const std::string owner = dot == std::string::npos ? "" : key.substr(0, dot);
    const Record& record = owner == "march" ? march_record() : owner == "dvr" ? dvr_record() : integrator_record();
    void* const target = owner == "march" ? static_cast<void*>(&settings.march)
                         : owner == "dvr" ? static_cast<void*>(&settings.dvr)
                                          : &settings;
    std::vector<std::string> keys;
    const Field* found = nullptr;
    const auto add = [&](const Record& of, const std::string& prefix) {
        for (const Field& field : of.fields) {
            if (field.kind == FieldKind::text || field.kind == FieldKind::by_hand) continue;  // no single value
            keys.push_back(prefix + std::string(field.name));
            if (&of == &record && keys.back() == key) found = &field;
        }
    };
    add(integrator_record(), "");
    add(march_record(), "march.");
    add(dvr_record(), "dvr.");
    if (equals == std::string::npos || !found)
        return Error{"--set '" + assignment + "': expected KEY=VALUE, KEY being one of " + list_names(keys)};
    std::string value = assignment.substr(equals + 1);
    if (found->kind == FieldKind::choice) value = '"' + value + '"';
    const Result<JsonDocument> document = parse_json(value, "--set");
    if (!document) return Error{"--set '" + assignment + "': the value is not a number"};
    JsonReader reader(*document);
    reader.field(document->root, *found, target, "integrator");
    if (!reader.error()) return {};
    // "--set:1:1: message": the place says nothing here.
    const std::string& message = reader.error()->message;
    return Error{"--set '" + assignment + "': " + message.substr(message.find(": ") + 2)};
}

}  // namespace spinel
