// The report as a page: tables, bars, lines and heat maps, drawings as SVG and pictures as PNG within the file.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>

#include "cli/bench/bench_report.h"
#include "core/atomic_file.h"
#include "image/image_io.h"
#include "kernels/heatmap.h"

namespace spinel::cli {
namespace {

constexpr const char* style = R"(<style>
body{font:15px/1.5 system-ui,sans-serif;max-width:1080px;margin:2em auto;padding:0 1em;color:#222;background:#fff}
h1{font-size:1.5em}h2{font-size:1.15em;margin-top:2em}p{max-width:44em}
table{border-collapse:collapse;font-variant-numeric:tabular-nums;font-size:13px}
td,th{padding:.2em .7em;text-align:right;border-bottom:1px solid #e5e5e5}td:first-child,th:first-child{text-align:left}
figure{display:inline-block;margin:0 1em 1em 0}figcaption{font-size:13px;color:#555}
svg text{font:12px system-ui,sans-serif;fill:#333}img{image-rendering:pixelated;width:256px;height:256px}
</style>
)";

constexpr const char* colors[] = {"#3b6fb6", "#d1495b", "#30915a", "#b7791f", "#7a5195", "#00838f",
                                  "#8d6e63", "#5c6bc0", "#ef6c00", "#546e7a", "#c2185b", "#689f38"};

std::string escaped(const std::string& text) {
    std::string out;
    for (const char c : text) {
        if (c == '<') out += "&lt;";
        else if (c == '>') out += "&gt;";
        else if (c == '&') out += "&amp;";
        else if (c == '"') out += "&quot;";
        else out += c;
    }
    return out;
}

std::string base64(const std::string& bytes) {
    constexpr const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        unsigned word = 0;
        for (std::size_t k = 0; k < 3; ++k)
            word = word << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
        for (std::size_t k = 0; k < 4; ++k) out += i + k <= bytes.size() ? digits[word >> (18 - 6 * k) & 63] : '=';
    }
    return out;
}

std::string short_number(double x) {
    if (x >= 1e6) return fmt::format("{:.3g}M", 1e-6 * x);
    if (x >= 1e4) return fmt::format("{:.3g}k", 1e-3 * x);
    return x >= 100 ? fmt::format("{:.0f}", x) : fmt::format("{:.3g}", x);
}

struct Bar {
    std::string label;
    double value;
};

// Lengths from zero, or where values differ by more than thirty times, logarithmic.
std::string bars(const std::string& caption, std::vector<Bar> list) {
    std::erase_if(list, [](const Bar& bar) { return !(bar.value > 0); });
    if (list.empty()) return {};
    const auto by_value = [](const Bar& a, const Bar& b) { return a.value < b.value; };
    const double most = std::max_element(list.begin(), list.end(), by_value)->value;
    const double least = std::min_element(list.begin(), list.end(), by_value)->value;
    const bool logarithmic = most > 30 * least;
    const auto length = [&](double x) {
        return logarithmic ? 20 + 220 * std::log(x / least) / std::log(most / least) : 240 * x / most;
    };
    const std::size_t height = 20 * list.size() + 6;
    std::string svg = fmt::format("<figure><figcaption>{}{}</figcaption><svg width=\"480\" height=\"{}\">", caption,
                                  logarithmic ? " (logarithmic)" : "", height);
    for (std::size_t i = 0; i < list.size(); ++i)
        svg += fmt::format(
            "<text x=\"150\" y=\"{0}\" text-anchor=\"end\">{1}</text><rect x=\"158\" y=\"{2}\" width=\"{3:.1f}\" "
            "height=\"14\" fill=\"{4}\"/><text x=\"{5:.1f}\" y=\"{0}\">{6}</text>",
            20 * i + 15, escaped(list[i].label), 20 * i + 4, length(list[i].value), colors[0],
            164 + length(list[i].value), short_number(list[i].value));
    return svg + "</svg></figure>\n";
}

std::string name_of(const BenchRow& row) {
    return row.preset.empty() ? row.structure : row.structure + " " + row.preset;
}

// One value of the rows of a subject and kind of rays.
std::string bars_of(const BenchReport& report, const std::string& caption, const std::string& subject,
                    const std::string& kind, const std::function<double(const BenchRow&)>& value) {
    std::vector<Bar> list;
    for (const BenchRow& row : report.rows)
        if (row.subject == subject && row.rays == kind) list.push_back({name_of(row), value(row)});
    return bars(caption, list);
}

std::string lines(const BenchReport& report, const std::string& caption,
                  const std::function<double(const ScalingRow&)>& value) {
    double least = 1e300, most = 0, fewest = 1e300, largest = 0;
    std::vector<std::string> names;
    for (const ScalingRow& row : report.scaling) {
        if (!(value(row) > 0)) continue;
        least = std::min(least, value(row)), most = std::max(most, value(row));
        fewest = std::min(fewest, double(row.triangles)), largest = std::max(largest, double(row.triangles));
        if (std::find(names.begin(), names.end(), row.structure) == names.end()) names.push_back(row.structure);
    }
    if (names.empty() || fewest >= largest || least >= most) return {};
    const auto x = [&](double n) { return 56 + 300 * std::log(n / fewest) / std::log(largest / fewest); };
    const auto y = [&](double v) { return 230 - 210 * std::log(v / least) / std::log(most / least); };
    std::string svg = fmt::format(
        "<figure><figcaption>{}, both axes logarithmic</figcaption><svg width=\"520\" height=\"270\"><path d=\"M56 "
        "15V235H360\" "
        "fill=\"none\" stroke=\"#999\"/><text x=\"52\" y=\"24\" text-anchor=\"end\">{}</text><text x=\"52\" y=\"232\" "
        "text-anchor=\"end\">{}</text><text x=\"56\" y=\"252\">{}</text><text x=\"356\" y=\"252\" "
        "text-anchor=\"end\">{} triangles</text>",
        caption, short_number(most), short_number(least), short_number(fewest), short_number(largest));
    for (std::size_t i = 0; i < names.size(); ++i) {
        std::string points;
        for (const ScalingRow& row : report.scaling)
            if (row.structure == names[i] && value(row) > 0)
                points += fmt::format("{:.1f},{:.1f} ", x(double(row.triangles)), y(value(row)));
        const char* color = colors[i % std::size(colors)];
        svg += fmt::format(
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"2\"/><rect x=\"376\" y=\"{}\" "
            "width=\"12\" "
            "height=\"4\" fill=\"{}\"/><text x=\"394\" y=\"{}\">{}</text>",
            points, color, 20 + 18 * i, color, 26 + 18 * i, escaped(names[i]));
    }
    return svg + "</svg></figure>\n";
}

// As a PNG; `most` is the hottest colour.
Result<std::string> heat_png(const HeatMap& map, double most) {
    Image image{map.edge, map.edge, 3, std::vector<float>(3 * map.counts.size())};
    for (std::size_t i = 0; i < map.counts.size(); ++i) {
        const vec3 c = kernels::heat_color(float(std::log1p(double(map.counts[i])) / std::log1p(most)));
        for (int k = 0; k < 3; ++k) image.values[3 * i + std::size_t(k)] = c[k];
    }
    const std::filesystem::path file = std::filesystem::temp_directory_path() /
                                       fmt::format("spinel-heat-{}.png", std::hash<std::string>{}(map.structure));
    NamedPlane plane{{"R", "G", "B"}, std::move(image)};
    if (const Result<void> written = write_image(file, {plane}); !written) return written.error();
    std::ifstream stream(file, std::ios::binary);
    std::string bytes((std::istreambuf_iterator<char>(stream)), {});
    stream.close();
    std::error_code ignored;
    std::filesystem::remove(file, ignored);
    return bytes;
}

std::string table(const BenchReport& report) {
    const auto line = [](const char* tag, std::initializer_list<std::string> cells) {
        std::string html = "<tr>";
        for (const std::string& cell : cells) html += fmt::format("<{0}>{1}</{0}>", tag, cell);
        return html + "</tr>\n";
    };
    std::string html = "<table>";
    html += line("th", {"structure", "rays", "Mrays/s", "build ms, 1 thread", "2 threads", "refit ms", "MB",
                        "expected cost", "depth", "nodes", "boxes", "tests"});
    const auto known = [](double x) { return x > 0 ? short_number(x) : std::string("–"); };
    for (const BenchRow& row : report.rows)
        html +=
            line("td", {escaped(row.subject + ": " + name_of(row)), row.rays, fmt::format("{:.2f}", row.mrays_per_s),
                        known(row.build_ms), known(row.build_ms_two_threads), known(row.refit_ms),
                        fmt::format("{:.2f}", 1e-6 * row.bytes), known(row.sah_cost), known(row.depth),
                        known(row.nodes_per_ray), known(row.boxes_per_ray), known(row.tests_per_ray)});
    return html + "</table>\n";
}

}  // namespace

Result<void> write_html(const BenchReport& report, const std::string& file) {
    std::string html = "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><title>spinel bench</title>\n";
    html += style;
    html += fmt::format(
        "<h1>spinel bench {}</h1>\n<p>{} triangles. One thread, single rays, medians of {} in processor time. Primary "
        "rays go through pixels, diffuse ones bounce once from what those hit, shadow rays ask for any hit towards a "
        "light. Cost is what the builder expects of a ray, in triangle tests.</p>\n",
        escaped(report.input), report.triangles, report.repeats);
    std::vector<std::string> subjects;
    for (const BenchRow& row : report.rows)
        if (std::find(subjects.begin(), subjects.end(), row.subject) == subjects.end()) subjects.push_back(row.subject);
    for (const std::string& subject : subjects) {
        html += "<h2>Speed, Mrays/s: " + escaped(subject) + "</h2>\n";
        for (const char* kind : {"primary", "diffuse", "shadow"})
            html += bars_of(report, kind, subject, kind, [](const BenchRow& r) { return r.mrays_per_s; });
    }
    html += "<h2>What a structure takes: meshes</h2>\n";
    html +=
        bars_of(report, "build on one thread, ms", "meshes", "primary", [](const BenchRow& r) { return r.build_ms; });
    html += bars_of(report, "build on two threads, ms", "meshes", "primary",
                    [](const BenchRow& r) { return r.build_ms_two_threads; });
    html += bars_of(report, "refit, where vertices move, ms", "meshes", "primary",
                    [](const BenchRow& r) { return r.refit_ms; });
    html +=
        bars_of(report, "bytes, triangles included", "meshes", "primary", [](const BenchRow& r) { return r.bytes; });
    html += "<h2>What a ray takes: meshes</h2>\n";
    for (const char* kind : {"primary", "diffuse", "shadow"}) {
        html += bars_of(report, fmt::format("{}: nodes or cells", kind), "meshes", kind,
                        [](const BenchRow& r) { return r.nodes_per_ray; });
        html += bars_of(report, fmt::format("{}: triangle tests", kind), "meshes", kind,
                        [](const BenchRow& r) { return r.tests_per_ray; });
    }
    if (!report.maps.empty()) {
        // One scale for all, which the costliest hundredth of all pixels exceeds.
        std::vector<std::uint32_t> all;
        for (const HeatMap& map : report.maps) all.insert(all.end(), map.counts.begin(), map.counts.end());
        const auto at = all.begin() + std::ptrdiff_t(all.size() * 99 / 100);
        std::nth_element(all.begin(), at, all.end());
        const double most = std::max(1.0, double(*at));
        html += fmt::format(
            "<h2>Heat maps</h2>\n<p>Nodes, boxes and triangles that the ray of a pixel asks: dark blue none, dark red "
            "{:.0f} and more, the same logarithmic scale everywhere.</p>\n",
            most);
        for (const HeatMap& map : report.maps) {
            const Result<std::string> png = heat_png(map, most);
            if (!png) return png.error();
            html += fmt::format(
                "<figure><img alt=\"{0}\" src=\"data:image/png;base64,{1}\"><figcaption>{0}</figcaption>"
                "</figure>\n",
                escaped(map.structure), base64(*png));
        }
    }
    if (!report.scaling.empty()) {
        html += "<h2>How it grows</h2>\n<p>The largest mesh and coarser versions of it, primary rays.</p>\n";
        html += lines(report, "nodes or cells for each ray", [](const ScalingRow& r) { return r.nodes_per_ray; });
        html += lines(report, "Mrays/s", [](const ScalingRow& r) { return r.mrays_per_s; });
        html += lines(report, "build on one thread, ms", [](const ScalingRow& r) { return r.build_ms; });
        html += lines(report, "speed-up of the build by two threads", [](const ScalingRow& r) {
            return r.build_ms_two_threads > 0 ? r.build_ms / r.build_ms_two_threads : 0;
        });
    }
    html += "<h2>All figures</h2>\n" + table(report) + "</html>\n";
    return write_file_atomically(file, html);
}

}  // namespace spinel::cli
