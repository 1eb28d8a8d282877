#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <nlohmann/json.hpp>

#include "cli/commands.h"
#include "devices/devices.h"
#include "geometry/mesh/mesh_structures.h"
#include "geometry/sdf/sdf_ops.h"
#include "render/render.h"
#include "scene/material_registry.h"
#include "scene/worlds/worlds.h"
#include "spinel/formats.h"
#include "spinel/trace.h"

namespace spinel::cli {
namespace {

struct Entry {
    std::string name;
    std::string doc;
};

template <class Rows>
std::vector<Entry> entries(const Rows& rows) {
    std::vector<Entry> list;
    list.reserve(std::size(rows));
    for (const auto& row : rows) list.push_back({std::string(row.name), std::string(row.doc)});
    return list;
}

struct Kind {
    const char* name;
    std::vector<Entry> (*list)();
};

const Kind kinds[] = {
    {"accelerators",
     [] {
         std::vector<Entry> list;
         for (const Accelerator& a : accelerators())
             list.push_back({a.name, a.description + (a.method == TraceMethod::walk ? "" : "; `spinel trace` alone")});
         return list;
     }},
    {"aovs", [] { return entries(aov_infos()); }},
    {"devices", [] { return entries(device_infos()); }},
    {"formats",
     [] {
         std::vector<Entry> list;
         for (const Format& format : formats()) {
             std::string doc;
             for (const auto extension : format.extensions) doc += std::string(extension) + " ";
             list.push_back({std::string(format.name), doc + " " + std::string(format.description)});
         }
         return list;
     }},
    {"integrators", [] { return entries(integrator_infos()); }},
    {"materials", [] { return entries(material_infos()); }},
    {"sdf", [] { return entries(sdf_operations()); }},
    {"triangle-tests",
     [] {
         std::vector<Entry> list;
         for (const TriangleTest& test : triangle_tests()) list.push_back({test.name, test.doc});
         return list;
     }},
    {"worlds", [] { return entries(worlds()); }},
};

}  // namespace

std::function<int()> list_command(CLI::App& app, const CommonOptions& common) {
    std::vector<std::string> names;
    for (const Kind& kind : kinds) names.push_back(kind.name);
    auto wanted = std::make_shared<std::string>();
    app.add_option("KIND", *wanted, "one of these; all if left out")->check(CLI::IsMember(names));
    return [wanted, &common] {
        nlohmann::ordered_json json;
        for (const Kind& kind : kinds) {
            if (!wanted->empty() && *wanted != kind.name) continue;
            if (!common.json && wanted->empty()) fmt::print("{}:\n", kind.name);
            const std::vector<Entry> list = kind.list();
            std::size_t width = 0;
            for (const Entry& entry : list) width = std::max(width, entry.name.size());
            for (const Entry& entry : list) {
                if (common.json) json[kind.name].push_back({{"name", entry.name}, {"doc", entry.doc}});
                else fmt::print("{}{:<{}}  {}\n", wanted->empty() ? "  " : "", entry.name, width, entry.doc);
            }
        }
        if (common.json) fmt::print("{}\n", json_text(json, 2));
        return int(exit_ok);
    };
}

}  // namespace spinel::cli
