// `spinel trace`: rays from a file, hits to a file, the same hits from every accelerator.

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "cli/run_program.h"
#include "spinel/trace.h"

namespace spinel::trace_test {
namespace {

// The bytes of a .npy file, format version 1.
std::string npy(const std::string& type, const std::string& shape, const std::string& data) {
    std::string header = "{'descr': " + type + ", 'fortran_order': False, 'shape': " + shape + ", }";
    header.append(63 - (10 + header.size()) % 64, ' ');
    header += '\n';
    return std::string("\x93NUMPY\x01\x00", 8) + raw(std::uint16_t(header.size())) + header + data;
}

std::string rays_npy(const std::vector<TraceRay>& rays) {
    return npy("'<f4'", "(" + std::to_string(rays.size()) + ", 8)",
               std::string(reinterpret_cast<const char*>(rays.data()), rays.size() * sizeof(TraceRay)));
}

// From a ball around the middle of the scene to points near it, as users send them: some start inside, some
// are cut short, directions have any length.
std::vector<TraceRay> random_rays(int count, glm::vec3 centre, float radius) {
    std::mt19937 random(20240229);
    std::normal_distribution<float> normal;
    std::uniform_real_distribution<float> uniform;
    const auto somewhere = [&](float scale) {
        return centre + scale * radius * glm::vec3(normal(random), normal(random), normal(random));
    };
    std::vector<TraceRay> rays;
    for (int i = 0; i < count; ++i) {
        const glm::vec3 origin = somewhere(i % 4 == 0 ? 0.3f : 1.5f), target = somewhere(0.4f);
        const float t_max = i % 5 == 0 ? 2 * uniform(random) : std::numeric_limits<float>::infinity();
        rays.push_back({origin, i % 7 == 0 ? 0.5f : 0.0f, target - origin, t_max});
    }
    return rays;
}

class CliTrace : public ProgramTest {
  protected:
    std::vector<TraceHit> trace(const std::string& input, const std::string& accelerator, std::size_t count,
                                std::vector<std::string> more = {}) const {
        std::vector<std::string> arguments = {"trace", input,          "--rays",  at("rays.npy"),
                                              "-o",    at("hits.npy"), "--accel", accelerator};
        arguments.insert(arguments.end(), more.begin(), more.end());
        const Outcome outcome = run(arguments);
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        EXPECT_EQ(outcome.out, "");
        EXPECT_NE(outcome.err.find("Mrays/s (" + accelerator + ")"), std::string::npos) << outcome.err;
        const std::string bytes = bytes_of(at("hits.npy"));
        std::vector<TraceHit> hits(count);
        const std::size_t length = count * sizeof(TraceHit);
        EXPECT_GT(bytes.size(), length);
        if (bytes.size() > length) std::memcpy(hits.data(), bytes.data() + bytes.size() - length, length);
        return hits;
    }

    // `grazes`: rays that may differ, for surfaces that the naive twin samples: it steps over what a ray only
    // scratches (by millionths of its size), and on a crease it may take the normal of the other side.
    void expect_accelerators_agree(const std::string& input, glm::vec3 centre, float radius, int count = 4000,
                                   std::size_t grazes = 0) {
        SCOPED_TRACE(input);
        const std::vector<TraceRay> rays = random_rays(count, centre, radius);
        write("rays.npy", rays_npy(rays));
        const auto fast = trace(input, "bvh2", rays.size()), naive = trace(input, "brute-force", rays.size());
        const auto any = trace(input, "bvh2", rays.size(), {"--any"});
        const auto naive_any = trace(input, "brute-force", rays.size(), {"--any", "--threads", "1"});
        std::size_t hit_count = 0, any_differs = 0, ties = 0, grazed = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const TraceHit &a = fast[i], &b = naive[i];
            const bool hit = std::isfinite(a.t);
            hit_count += hit;
            ASSERT_EQ(hit, std::isfinite(b.t)) << "ray " << i;
            any_differs += hit != (any[i].t == 0);
            any_differs += hit != (naive_any[i].t == 0);
            if (!hit) {
                EXPECT_EQ(a.instance, ~0u);
                EXPECT_EQ(a.material, ~0u);
                continue;
            }
            EXPECT_GT(a.t, rays[i].t_min);
            EXPECT_LT(a.t, rays[i].t_max);
            const float length = glm::length(rays[i].direction),
                        tolerance = 2e-4f * (radius + glm::length(rays[i].origin)) / length;
            const bool same_t = std::abs(a.t - b.t) <= tolerance;
            const bool same_normal = a.nx * b.nx + a.ny * b.ny + a.nz * b.nz > 0.99f;
            if (grazed < grazes && (!same_t || !same_normal)) {
                ++grazed;
                continue;
            }
            EXPECT_TRUE(same_t) << "ray " << i << ": " << a.t << " and " << b.t;
            if (a.instance != b.instance || a.primitive != b.primitive || a.ix != b.ix || a.iy != b.iy ||
                a.iz != b.iz) {
                ++ties;  // an edge between two: the distance already agreed
                continue;
            }
            EXPECT_EQ(a.material, b.material) << "ray " << i;
            EXPECT_NEAR(a.nx * a.nx + a.ny * a.ny + a.nz * a.nz, 1.0f, 1e-4f) << "ray " << i;
            EXPECT_TRUE(same_normal) << "ray " << i;
        }
        EXPECT_GT(hit_count, rays.size() / 20) << "a test that hits nothing proves nothing";
        EXPECT_LT(hit_count, rays.size());
        EXPECT_LE(ties, rays.size() / 500);
        EXPECT_EQ(any_differs, 0u);
    }
};

// A wavy grid of triangles as OBJ.
std::string wavy_obj(int n) {
    std::string text;
    for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i) {
            const double x = 2.0 * i / n - 1, z = 2.0 * j / n - 1;
            text += "v " + std::to_string(x) + " " + std::to_string(0.3 * std::sin(7 * x) * std::cos(5 * z)) + " " +
                    std::to_string(z) + "\n";
        }
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            const int a = j * (n + 1) + i + 1, b = a + 1, c = a + n + 1, d = c + 1;
            for (const auto& f : {std::array{a, c, b}, std::array{b, c, d}})
                text += "f " + std::to_string(f[0]) + " " + std::to_string(f[1]) + " " + std::to_string(f[2]) + "\n";
        }
    return text;
}

// A ball of voxels in two colours with a glass shell of cells, as a MagicaVoxel file.
std::string ball_vox(int n) {
    std::string cells;
    int count = 0;
    for (int z = 0; z < n; ++z)
        for (int y = 0; y < n; ++y)
            for (int x = 0; x < n; ++x) {
                const double r = std::hypot(x - 0.5 * n + 0.5, y - 0.5 * n + 0.5, z - 0.5 * n + 0.5) / (0.5 * n);
                if (r > 1 || (x * 7 + y * 3 + z * 5) % 11 == 0) continue;
                cells += {char(x), char(y), char(z), char(r > 0.8 ? 3 : 1 + (x + y) % 2)};
                ++count;
            }
    const auto chunk = [](const std::string& id, const std::string& content) {
        return id + raw<int>(int(content.size())) + raw<int>(0) + content;
    };
    const std::string children = chunk("SIZE", raw(n) + raw(n) + raw(n)) + chunk("XYZI", raw(count) + cells);
    return "VOX " + raw<int>(150) + "MAIN" + raw<int>(0) + raw<int>(int(children.size())) + children;
}

const std::string sdf_object =
    R"json({"geometry": {"type": "sdf", "expression": "difference(smooth_union(0.2, sphere(0.8), torus(1, 0.3)), box(0.7, 3, 0.7))"},
    "material": "matte", "transform": [{"rotate": {"axis": [1, 2, 3], "degrees": 40}}]})json";

std::string scene_of(const std::string& objects) {
    return R"({"version": 1, "materials": {"matte": {"type": "diffuse"}, "glass": {"type": "dielectric"}}, "objects": [)" +
           objects + "]}";
}

TEST_F(CliTrace, accelerators_agree_on_a_mesh) {
    expect_accelerators_agree(write("wavy.obj", wavy_obj(40)).string(), {0, 0, 0}, 1);
}

TEST_F(CliTrace, accelerators_agree_on_voxels) {
    expect_accelerators_agree(write("ball.vox", ball_vox(21)).string(), {0, 10, 0}, 10);
}

TEST_F(CliTrace, accelerators_agree_on_voxels_of_an_artist) {
    const std::filesystem::path file = data_folder / "vox/ephtracy/chr_knight.vox";
    if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not at hand";
    expect_accelerators_agree(file.string(), {0, 10, 0}, 12);
}

TEST_F(CliTrace, accelerators_agree_on_an_implicit_surface) {
    expect_accelerators_agree(write("solid.json", scene_of(sdf_object)).string(), {0, 0, 0}, 1.2f, 2000, 10);
}

TEST_F(CliTrace, accelerators_agree_on_all_of_them_together) {
    write("wavy.obj", wavy_obj(12));
    write("ball.vox", ball_vox(9));
    const std::string objects = sdf_object + R"(,
  {"geometry": {"type": "mesh", "file": "wavy.obj"}, "material": "glass", "transform": [{"scale": [2, 1, -1.5]}, {"translate": [1, 0.5, 0]}]},
  {"geometry": {"type": "mesh", "file": "wavy.obj"}, "material": "matte", "transform": [{"rotate": {"axis": [1, 0, 0], "degrees": 70}}]},
  {"geometry": {"type": "voxels", "file": "ball.vox"}, "transform": [{"scale": 0.1}, {"translate": [-1, -0.5, 0.7]}]},
  {"geometry": {"type": "sphere", "radius": 0.7}, "material": "glass", "transform": [{"scale": [1, 2, 0.5]}, {"translate": [0, -1, 0]}]},
  {"geometry": {"type": "box", "size": [1, 0.2, 1]}, "material": "matte", "transform": [{"translate": [0, 1, -1]}]},
  {"geometry": {"type": "rectangle", "size": [3, 3]}, "material": "matte", "transform": [{"translate": [0, -1.4, 0]}]},
  {"geometry": {"type": "sphere"}, "material": null, "transform": [{"translate": [1, 0, 1]}]})";
    expect_accelerators_agree(write("all.json", scene_of(objects)).string(), {0, 0, 0}, 1.5f, 2000, 5);
}

TEST_F(CliTrace, a_hit_is_what_geometry_says) {
    write("ball.json", scene_of(R"({"geometry": {"type": "sphere", "radius": 2}, "material": "glass"})"));
    const float inf = std::numeric_limits<float>::infinity();
    write("rays.npy", rays_npy({{{0, 0, 10}, 0, {0, 0, -2}, inf},   // t in units of |direction|: 8 / 2
                                {{0, 0, 10}, 5, {0, 0, -2}, inf},   // the far side, from within the segment
                                {{0, 0, 10}, 0, {0, 0, -2}, 3.9f},  // too short
                                {{0, 0, 10}, 0, {0, 0, 2}, inf},    // away
                                {{0, 0, 0}, 0, {0, 0, 0}, inf},     // no direction
                                {{NAN, 0, 0}, 0, {0, 1, 0}, inf}}));
    const std::vector<TraceHit> hits = trace(at("ball.json"), "bvh2", 6);
    EXPECT_NEAR(hits[0].t, 4.0f, 1e-5f);
    EXPECT_EQ(hits[0].instance, 0u);
    EXPECT_NEAR(hits[0].nz, 1.0f, 1e-5f);
    EXPECT_NEAR(hits[1].t, 6.0f, 1e-5f);
    EXPECT_NEAR(hits[1].nz, -1.0f, 1e-5f) << "normals point outwards";
    for (int i = 2; i < 6; ++i) EXPECT_EQ(hits[std::size_t(i)].t, inf) << i;
}

TEST_F(CliTrace, json_tells_the_rate) {
    write("ball.json", scene_of(R"({"geometry": {"type": "sphere"}, "material": "matte"})"));
    write("rays.npy", rays_npy(random_rays(100, {0, 0, 0}, 1)));
    const Outcome outcome = run({"trace", at("ball.json"), "--rays", at("rays.npy"), "-o", at("hits.npy"), "--json"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.err, "");
    const auto json = nlohmann::json::parse(outcome.out);
    EXPECT_EQ(json["rays"], 100);
    EXPECT_GT(json["hits"].get<int>(), 0);
    EXPECT_LT(json["hits"].get<int>(), 100);
    EXPECT_GT(json["mrays_per_s"].get<double>(), 0);
    const Outcome quiet = run({"trace", at("ball.json"), "--rays", at("rays.npy"), "-o", at("hits.npy"), "--quiet"});
    EXPECT_EQ(quiet.code, 0);
    EXPECT_EQ(quiet.out + quiet.err, "");
}

TEST_F(CliTrace, no_rays_give_no_hits) {
    write("ball.json", scene_of(R"({"geometry": {"type": "sphere"}, "material": "matte"})"));
    write("rays.npy", npy("'<f4'", "(0, 8)", ""));
    EXPECT_EQ(run({"trace", at("ball.json"), "--rays", at("rays.npy"), "-o", at("hits.npy")}).code, 0);
    const std::string bytes = bytes_of(at("hits.npy"));
    EXPECT_NE(bytes.find("'shape': (0,)"), std::string::npos);
    EXPECT_EQ(bytes.size() % 64, 0u);
}

TEST_F(CliTrace, wrong_rays_are_refused) {
    write("ball.json", scene_of(R"({"geometry": {"type": "sphere"}, "material": "matte"})"));
    const std::string ray(32, '\0');
    std::string fortran = npy("'<f4'", "(2, 8)", ray + ray);
    fortran.replace(fortran.find("False"), 5, "True ");
    const std::vector<std::pair<std::string, std::string>> wrong = {
        {npy("'<f8'", "(1, 8)", ray + ray), "'<f4'"},
        {npy("'>f4'", "(1, 8)", ray), "'<f4'"},
        {npy("'<i4'", "(1, 8)", ray), "'<f4'"},
        {npy("[('t', '<f4')]", "(8,)", ray), "'<f4'"},
        {npy("'<f4'", "(8, 1)", ray), "(N, 8)"},
        {npy("'<f4'", "(8,)", ray), "(N, 8)"},
        {npy("'<f4'", "(1, 2, 4)", ray), "(N, 8)"},
        {npy("'<f4'", "(1,\n 4)", ray), "found (1,? 4)"},
        {npy("'<f4'", "(2, 8)", ray), "32"},
        {npy("'<f4'", "(1, 8)", ray + "x"), "33"},
        {npy("'<f4'", "(99999999999999999999, 8)", ray), "rays.npy"},
        {fortran, "C order"},
        {npy("'<f4'", "(1, 8)", ray).substr(0, 40), "header"},
        {"rays", "not a .npy file"},
        {"", "not a .npy file"},
    };
    for (const auto& [bytes, why] : wrong) {
        write("rays.npy", bytes);
        expect_complaint(run({"trace", at("ball.json"), "--rays", at("rays.npy"), "-o", at("hits.npy")}), 1, why);
        EXPECT_EQ(files(), (std::vector<std::string>{"ball.json", "rays.npy"}));
    }
    std::filesystem::remove(at("rays.npy"));
    expect_complaint(run({"trace", at("ball.json"), "--rays", at("rays.npy"), "-o", at("hits.npy")}), 1,
                     "there is no such file");
    write("rays.npy", rays_npy(random_rays(1, {0, 0, 0}, 1)));
    expect_complaint(run({"trace", at("ball.json"), "--rays", at("rays.npy"), "-o", at("none/hits.npy")}), 1, "none");
    expect_complaint(
        run({"trace", at("ball.json"), "--rays", at("rays.npy"), "-o", at("hits.npy"), "--accel", "octree"}), 2,
        "available: wide-bvh8, wide-bvh8-compact, bvh2, ");
    expect_complaint(run({"trace", at("ball.json"), "--rays", at("rays.npy"), "-o", at("hits.npy"), "--triangle-test",
                          "barycentric"}),
                     2, "available: watertight, moller-trumbore");
    expect_complaint(run({"trace", at("none.json"), "--rays", at("rays.npy"), "-o", at("hits.npy")}), 1, "none.json");
}

TEST_F(CliTrace, heights_and_frames_are_chosen_as_for_a_picture) {
    write("step.pgm", std::string("P5\n2 1\n255\n\x00\xff", 13));
    // Down on both columns.
    write("rays.npy", rays_npy({{{0.5f, 100, 0.5f}, 0, {0, -1, 0}, 1000}, {{1.5f, 100, 0.5f}, 0, {0, -1, 0}, 1000}}));
    const auto hits = trace(at("step.pgm"), "bvh2", 2, {"--heightmap", "12"});
    EXPECT_EQ(hits[0].t, 99.0f);
    EXPECT_EQ(hits[1].t, 88.0f);
    const std::vector<std::string> rays = {"--rays", at("rays.npy"), "-o", at("hits.npy")};
    const auto refused = [&](std::vector<std::string> arguments, int code, const std::string& why) {
        arguments.insert(arguments.begin(), "trace");
        arguments.insert(arguments.end(), rays.begin(), rays.end());
        expect_complaint(run(arguments), code, why);
    };
    refused({at("step.pgm")}, 1, "--heightmap");
    refused({at("step.pgm"), "--heightmap", "nan"}, 2, "--heightmap");
    refused({at("step.pgm"), "--heightmap", "12", "--frame", "1"}, 1, "no frames");
    write("scene.json", R"({"version": 1})");
    refused({at("scene.json"), "--frame", "1"}, 1, "the scene has no \"animation\"");
}

}  // namespace
}  // namespace spinel::trace_test
