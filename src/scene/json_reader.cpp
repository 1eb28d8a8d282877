#include "scene/json_reader.h"

#include "scene/animation.h"
#include "scene/json_context.h"
#include "scene/validate.h"

namespace spinel {
namespace {

// Calls `read(member, index)` for each member of an object of named things.
template <class Function>
void each_named(JsonContext& context, const JsonValue& value, const std::string& key, const Function& read) {
    if (!value.object()) {
        context.json.fail(value, "\"" + key + "\" must be an object of names, not " + value.description());
        return;
    }
    for (std::size_t i = 0; i < value.object()->size(); ++i) read((*value.object())[i], i);
}

// Things refer to each other by name, in any order: the names are known before the things are read.
void collect_names(JsonContext& context, const JsonValue& root, const char* key, NameTable& table) {
    const JsonValue* value = root.find(key);
    if (!value) return;
    each_named(context, *value, key, [&](const JsonMember& member, std::size_t) {
        if (member.key.empty()) context.json.fail(member.offset, "a " + table.noun + " needs a name");
        table.add(member.key);
    });
}

std::shared_ptr<const PixelBuffer> read_pixels(JsonContext& context, const JsonValue& owner, const std::string& what) {
    const JsonValue* file = owner.find("file");
    if (!file) return nullptr;  // said already: it is required
    const auto path = read_path(context, *file, "\"file\" of " + what);
    if (path.empty()) return nullptr;
    std::shared_ptr<const PixelBuffer>& known = context.pictures[path.string()];
    if (known) return known;
    Result<PixelBuffer> pixels = context.loaders.pixels(path);
    if (!pixels) {
        context.json.fail(*file, pixels.error().message);
        return nullptr;
    }
    return known = std::make_shared<const PixelBuffer>(*std::move(pixels));
}

// Reports what a thing is at fault with, unless an earlier error is the reason.
template <class T>
void check(JsonContext& context, const JsonValue& value, const T& thing, const std::string& what) {
    if (context.json.error()) return;
    if (const auto f = fault(thing)) context.json.fail(value, what + " " + *f);
}

void read_camera(JsonContext& context, const JsonValue& value, const std::string& name) {
    const std::string what = name.empty() ? "camera" : named("camera", name);
    const Record* record = context.json.select(value, camera_family(), what);
    if (!record) return;
    Camera camera;
    camera.name = name;
    camera.kind = Camera::Kind(record - camera_family().records.data());
    context.json.record(value, *record, &camera, what);
    check(context, value, camera, what);
    context.scene.cameras.push_back(std::move(camera));
}

void read_environment(JsonContext& context, const JsonValue& value) {
    const Family& family = environment_family();
    const Record* record = context.json.select(value, family, "environment");
    if (!record) return;
    EnvironmentData& environment = context.scene.environment;
    void* data = emplace<1>(environment, family, *record);
    context.json.record(value, *record, data, "environment");
    if (auto* image = std::get_if<ImageEnvironment>(&environment)) {
        image->pixels = read_pixels(context, value, "environment");
        if (image->pixels) image->file = *value.find("file")->text();
    }
    check(context, value, environment, "environment");
}

// Rectangles of an atlas for the six faces, the most particular key first.
void read_faces(JsonContext& context, const JsonValue& value, const std::string& what, FaceTexture& texture) {
    static constexpr const char* names[6] = {"west", "east", "bottom", "top", "north", "south"};
    float grid[2] = {1, 1};
    if (const JsonValue* given = value.find("grid"))
        if (!context.json.numbers(*given, 2, {1, 65536}, "\"grid\" of " + what, grid)) return;
    const ivec2 picture = {texture.pixels->width, texture.pixels->height}, tiles = {int(grid[0]), int(grid[1])};
    if (vec2(tiles) != vec2(grid[0], grid[1]) || picture.x % tiles.x != 0 || picture.y % tiles.y != 0)
        return context.json.fail(value, "\"grid\" of " + what + " must divide the picture's " +
                                            std::to_string(picture.x) + "×" + std::to_string(picture.y) +
                                            " pixels into tiles");
    for (int face = 0; face < 6; ++face) {
        const char* key = names[face];
        const JsonValue* part = value.find(key);
        const bool side = face / 2 != 1;
        if (!part && side) part = value.find(key = "sides");
        if (!part) part = value.find(key = "all");
        const std::string where = "\"" + std::string(key) + "\" of " + what;
        if (!part)
            return context.json.fail(value, what + " has no \"" + names[face] + "\"" + (side ? ", \"sides\"" : "") +
                                                " or \"all\": every face needs a part of the atlas");
        glm::ivec4& rectangle = texture.faces[std::size_t(face)];
        if (part->array()) {
            float r[4] = {};
            if (!context.json.numbers(*part, 4, {0, 65536}, where, r)) return;
            rectangle = glm::ivec4(r[0], r[1], r[2], r[3]);
            if (vec4(rectangle) != vec4(r[0], r[1], r[2], r[3]))
                return context.json.fail(*part, where + " must be whole numbers of pixels");
        } else {
            const auto tile = context.json.integer(*part, {0, double(tiles.x * tiles.y - 1)}, where);
            if (!tile) return;
            const ivec2 size = picture / tiles;
            rectangle = {(*tile % tiles.x) * size.x, (*tile / tiles.x) * size.y, size.x, size.y};
        }
    }
}

void read_textures(JsonContext& context, const JsonValue& value) {
    const Family& family = texture_family();
    each_named(context, value, "textures", [&](const JsonMember& member, std::size_t index) {
        const std::string what = named("texture", member.key);
        Texture& texture = context.scene.textures[index];
        texture.name = member.key;
        const Record* record = context.json.select(member.value, family, what);
        if (!record) return;
        void* data = emplace(texture.data, family, *record);
        context.json.record(member.value, *record, data, what);
        const auto read_picture = [&](auto& picture) {
            picture.pixels = read_pixels(context, member.value, what);
            if (!picture.pixels) return;
            picture.file = *member.value.find("file")->text();
            // Floating-point pictures are linear, unless the scene says otherwise.
            if (!member.value.find("srgb") && std::holds_alternative<std::vector<float>>(picture.pixels->data))
                picture.srgb = false;
        };
        if (auto* image = std::get_if<ImageTexture>(&texture.data)) read_picture(*image);
        if (auto* faces = std::get_if<FaceTexture>(&texture.data)) {
            read_picture(*faces);
            if (faces->pixels) read_faces(context, member.value, what, *faces);
        }
        check(context, member.value, texture, what);
    });
}

// The grid of the volume that "density", "albedo" or "temperature" names.
int read_volume(JsonContext& context, const JsonValue& medium, const char* key, const std::string& what) {
    const JsonValue* found = medium.find(key);
    if (!found) return -1;
    const JsonValue& value = *found;
    const std::string where = "\"" + std::string(key) + "\" of " + what;
    const int geometry = context.json.reference(value, context.geometries, where);
    if (geometry < 0) return -1;
    for (const Object& part : context.geometry_parts[std::size_t(geometry)].objects)
        if (const auto* volume =
                std::get_if<VolumeGeometry>(&context.scene.geometries[std::size_t(part.geometry)].data)) {
            if (!context.scene.grids[std::size_t(volume->grid)].level_set) return volume->grid;
            context.json.fail(value, where + ": geometry \"" + *value.text() +
                                         "\" holds distances; \"as\": \"fog\" makes them densities");
            return -1;
        }
    context.json.fail(value, where + ": geometry \"" + *value.text() + "\" is not a volume");
    return -1;
}

void read_media(JsonContext& context, const JsonValue& value) {
    each_named(context, value, "media", [&](const JsonMember& member, std::size_t index) {
        const std::string what = named("medium", member.key);
        Medium& medium = context.scene.media[index];
        medium.name = member.key;
        context.json.record(member.value, medium_record(), &medium, what);
        medium.grid = read_volume(context, member.value, "density", what);
        medium.albedo = read_volume(context, member.value, "albedo", what);
        medium.temperature = read_volume(context, member.value, "temperature", what);
        if (const JsonValue* erosion = member.value.find("erosion"))
            context.json.record(*erosion, erosion_record(), &medium.erosion, "erosion of " + what);
        check(context, member.value, medium, what);
    });
}

void read_lights(JsonContext& context, const JsonValue& value) {
    const Family& family = light_family();
    context.json.elements(value, "\"lights\"", [&](const JsonValue& element, std::size_t index) {
        Light light;
        if (const JsonValue* name = element.find("name"))
            light.name = context.json.text(*name, "\"name\" of lights[" + std::to_string(index) + "]").value_or("");
        const std::string what =
            light.name.empty() ? "lights[" + std::to_string(index) + "]" : named("light", light.name);
        const Record* record = context.json.select(element, family, what);
        if (!record) return;
        void* data = emplace(light.data, family, *record);
        context.json.record(element, *record, data, what);
        check(context, element, light, what);
        context.scene.lights.push_back(std::move(light));
    });
}

void read_dvr(JsonContext& context, const JsonValue& value) {
    DvrOptions& dvr = context.scene.integrator.dvr;
    context.json.record(value, dvr_record(), &dvr, "dvr of integrator");
    if (const JsonValue* points = value.find("points"))
        context.json.elements(*points, "\"points\" of dvr", [&](const JsonValue& element, std::size_t index) {
            const std::string what = "points[" + std::to_string(index) + "] of dvr";
            context.json.record(element, transfer_point_record(), &dvr.points.emplace_back(), what);
        });
    if (const JsonValue* planes = value.find("clip_planes"))
        context.json.elements(*planes, "\"clip_planes\" of dvr", [&](const JsonValue& element, std::size_t) {
            context.json.numbers(element, 4, any, "a plane of \"clip_planes\"", &dvr.clip_planes.emplace_back().x);
        });
    check(context, value, dvr, "dvr of integrator");
}

void read_version(JsonContext& context, const JsonValue& root) {
    const JsonValue* version = root.find("version");
    if (!version) return;  // record() says that it is required
    if (!version->number() || *version->number() != 1)
        context.json.fail(*version, "\"version\" must be 1, the only version of scene files there is");
}

void read_scene(JsonContext& context, const JsonValue& root) {
    Scene& scene = context.scene;
    if (!context.json.record(root, scene_record(), nullptr, "the scene")) return;
    read_version(context, root);
    collect_names(context, root, "textures", context.textures);
    collect_names(context, root, "materials", context.materials);
    collect_names(context, root, "media", context.media);
    collect_names(context, root, "geometries", context.geometries);
    scene.textures.resize(context.textures.names.size());
    scene.materials.resize(context.materials.names.size());
    scene.media.resize(context.media.names.size());

    const auto read = [&](const char* key, const auto& function) {
        if (const JsonValue* value = root.find(key)) function(*value);
    };
    read("film", [&](const JsonValue& value) { context.json.record(value, film_record(), &scene.film, "film"); });
    read("integrator", [&](const JsonValue& value) {
        context.json.record(value, integrator_record(), &scene.integrator, "integrator");
        if (const JsonValue* march = value.find("march"))
            context.json.record(*march, march_record(), &scene.integrator.march, "march of integrator");
        if (const JsonValue* dvr = value.find("dvr")) read_dvr(context, *dvr);
    });
    read("accelerator", [&](const JsonValue& value) {
        context.json.record(value, accelerator_record(), &scene.accelerator, "accelerator");
    });
    read("expected", [&](const JsonValue& value) {
        context.json.record(value, expected_record(), &scene.expected.emplace(), "expected");
    });
    read("camera", [&](const JsonValue& value) { read_camera(context, value, ""); });
    read("cameras", [&](const JsonValue& value) {
        if (root.find("camera")) context.json.fail(value, "\"camera\" and \"cameras\" exclude each other");
        each_named(context, value, "cameras",
                   [&](const JsonMember& member, std::size_t) { read_camera(context, member.value, member.key); });
    });
    read("environment", [&](const JsonValue& value) { read_environment(context, value); });
    read("textures", [&](const JsonValue& value) { read_textures(context, value); });
    read("geometries", [&](const JsonValue& value) { read_geometries(context, value); });
    read("media", [&](const JsonValue& value) { read_media(context, value); });
    read("materials", [&](const JsonValue& value) { read_materials(context, value); });
    read("objects", [&](const JsonValue& value) { read_objects(context, value); });
    read("lights", [&](const JsonValue& value) { read_lights(context, value); });
}

}  // namespace

std::filesystem::path read_path(JsonContext& context, const JsonValue& value, const std::string& where) {
    const auto text = context.json.text(value, where);
    if (!text) return {};
    return context.folder / std::filesystem::path(*text);
}

Result<Scene> read_scene_json(std::string_view text, const std::filesystem::path& file, const SceneLoaders& loaders,
                              const Moment& moment) {
    Result<JsonDocument> document = parse_json(std::string(text), file.string());
    if (!document) return document.error();
    if (const Result<void> moved = apply_animation(*document, moment); !moved) return moved.error();
    Scene scene;
    JsonReader json(*document);
    JsonContext context{json, loaders, file.parent_path(), scene};
    json.textures = &context.textures;
    read_scene(context, document->root);
    if (json.error()) return *json.error();
    if (const Result<void> valid = validate(scene); !valid) return Error{file.string() + ": " + valid.error().message};
    return scene;
}

}  // namespace spinel
