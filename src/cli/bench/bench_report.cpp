#include "cli/bench/bench_report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "cli/commands.h"

namespace spinel::cli {
namespace {

std::string number(double x, const char* unknown = "-") { return x < 0 ? unknown : fmt::format("{:.1f}", x); }

}  // namespace

std::string table_text(const BenchReport& report) {
    std::string text =
        fmt::format("{}: one thread, median of {}, processor time\n", report.input, report.repeats) +
        fmt::format("{:<8} {:<26} {:<8} {:>8} {:>9} {:>9} {:>8} {:>6} {:>6} {:>6} {:>9} {:>9} {:>7} {:>5} {:>8}\n",
                    "subject", "structure", "rays", "Mrays/s", "build ms", "2 threads", "refit ms", "nodes", "boxes",
                    "tests", "MB", "B/tri", "cost", "depth", "differ");
    for (const BenchRow& row : report.rows) {
        const std::string name = row.preset.empty() ? row.structure : row.structure + " " + row.preset;
        const bool meshes = row.subject == "meshes" && report.triangles > 0;
        text += fmt::format(
            "{:<8} {:<26} {:<8} {:>8.3f} {:>9.2f} {:>9} {:>8} {:>6} {:>6} {:>6} {:>9.3f} {:>9} {:>7} {:>5} {:>8}\n",
            row.subject, name, row.rays, row.mrays_per_s, row.build_ms,
            row.build_ms_two_threads > 0 ? fmt::format("{:.2f}", row.build_ms_two_threads) : "-",
            row.refit_ms > 0 ? fmt::format("{:.2f}", row.refit_ms) : "-", number(row.nodes_per_ray),
            number(row.boxes_per_ray), number(row.tests_per_ray), 1e-6 * row.bytes,
            meshes ? number(row.bytes / double(report.triangles)) : "-", row.sah_cost > 0 ? number(row.sah_cost) : "-",
            row.depth > 0 ? fmt::format("{}", row.depth) : "-",
            row.differing < 0 ? "-" : fmt::format("{:.4f}%", 100 * row.differing));
    }
    if (!report.scaling.empty())
        text += fmt::format("\n{:<18} {:>10} {:>10} {:>10} {:>9} {:>7} {:>7}\n", "structure", "triangles", "build ms",
                            "2 threads", "Mrays/s", "nodes", "tests");
    for (const ScalingRow& row : report.scaling)
        text +=
            fmt::format("{:<18} {:>10} {:>10.2f} {:>10.2f} {:>9.3f} {:>7.1f} {:>7.1f}\n", row.structure, row.triangles,
                        row.build_ms, row.build_ms_two_threads, row.mrays_per_s, row.nodes_per_ray, row.tests_per_ray);
    if (!report.look_ups.empty())
        text += fmt::format("{:<8} {:<20} {:<8} {:>9} {:>13} {:>13} {:>11}\n", "subject", "structure", "places", "M/s",
                            "bytes", "bytes/voxel", "difference");
    for (const LookUpRow& row : report.look_ups)
        text += fmt::format("{:<8} {:<20} {:<8} {:>9.3f} {:>13.0f} {:>13.3f} {:>11.2g}\n", "volume", row.structure,
                            row.places, row.mlookups_per_s, row.bytes, row.bytes_per_voxel, row.difference);
    return text;
}

std::string rows_json(const BenchReport& report) {
    nlohmann::ordered_json rows = nlohmann::ordered_json::array(), scaling = nlohmann::ordered_json::array();
    for (const BenchRow& row : report.rows) {
        nlohmann::ordered_json json = {{"subject", row.subject},
                                       {"structure", row.structure},
                                       {"preset", row.preset},
                                       {"rays", row.rays},
                                       {"mrays_per_s", row.mrays_per_s},
                                       {"build_ms", row.build_ms},
                                       {"bytes", row.bytes},
                                       {"nodes_per_ray", nullptr},
                                       {"boxes_per_ray", nullptr},
                                       {"tests_per_ray", nullptr},
                                       {"differing", nullptr}};
        if (row.differing >= 0) json["differing"] = row.differing;
        if (row.nodes_per_ray >= 0) {
            json["nodes_per_ray"] = row.nodes_per_ray;
            json["boxes_per_ray"] = row.boxes_per_ray;
            json["tests_per_ray"] = row.tests_per_ray;
        }
        if (row.build_ms_two_threads > 0) json["build_ms_two_threads"] = row.build_ms_two_threads;
        if (row.refit_ms > 0) json["refit_ms"] = row.refit_ms;
        if (row.sah_cost > 0) json["sah_cost"] = row.sah_cost;
        if (row.depth > 0) json["depth"] = row.depth;
        rows.push_back(std::move(json));
    }
    for (const ScalingRow& row : report.scaling)
        scaling.push_back({{"structure", row.structure},
                           {"triangles", row.triangles},
                           {"build_ms", row.build_ms},
                           {"build_ms_two_threads", row.build_ms_two_threads},
                           {"mrays_per_s", row.mrays_per_s},
                           {"nodes_per_ray", row.nodes_per_ray},
                           {"tests_per_ray", row.tests_per_ray}});
    nlohmann::ordered_json whole = {{"rows", rows}};
    if (!scaling.empty()) whole["scaling"] = scaling;
    for (const LookUpRow& row : report.look_ups)
        whole["look_ups"].push_back({{"structure", row.structure},
                                     {"places", row.places},
                                     {"mlookups_per_s", row.mlookups_per_s},
                                     {"bytes", row.bytes},
                                     {"bytes_per_voxel", row.bytes_per_voxel},
                                     {"difference", row.difference}});
    return json_text(whole, 2);
}

}  // namespace spinel::cli
