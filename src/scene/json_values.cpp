#include "scene/json_values.h"

#include <cmath>
#include <cstring>
#include <string>

#include "scene/number_text.h"

namespace spinel {

OrderedJson json_number(float x) {
    if (x == std::floor(x) && std::abs(x) < 1e9f) return int(x);
    return std::stod(number_text(x));
}

OrderedJson json_value(const Field& field, const void* record) {
    const char* const member = static_cast<const char*>(record) + field.offset;
    const auto vector = [](const auto& v, int count) {
        OrderedJson array = OrderedJson::array();
        for (int i = 0; i < count; ++i) array.push_back(json_number(float(v[i])));
        return array;
    };
    switch (field.kind) {
        case FieldKind::boolean: return *reinterpret_cast<const bool*>(member);
        case FieldKind::flag: return *reinterpret_cast<const kernels::uint*>(member) != 0;
        case FieldKind::integer: return *reinterpret_cast<const int*>(member);
        case FieldKind::number: return json_number(*reinterpret_cast<const float*>(member));
        case FieldKind::text: return *reinterpret_cast<const std::string*>(member);
        case FieldKind::choice: {
            int index = 0;
            std::memcpy(&index, member, sizeof(int));
            return std::string(field.choices[std::size_t(index)]);
        }
        case FieldKind::vec2: return vector(*reinterpret_cast<const vec2*>(member), 2);
        case FieldKind::vec3: return vector(*reinterpret_cast<const vec3*>(member), 3);
        case FieldKind::color: {
            const vec3& color = *reinterpret_cast<const vec3*>(member);
            return color == vec3(color.x) ? json_number(color.x) : vector(color, 3);
        }
        case FieldKind::size2: return vector(*reinterpret_cast<const ivec2*>(member), 2);
        case FieldKind::size3: return vector(*reinterpret_cast<const ivec3*>(member), 3);
        case FieldKind::by_hand: break;
    }
    return nullptr;
}

}  // namespace spinel
