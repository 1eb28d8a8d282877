#include "image/flip.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <numbers>
#include <vector>

#include "core/parallel.h"
#include "image/metrics.h"
#include "image/tone_map.h"

namespace spinel {
namespace {

using glm::dmat3;
using glm::dvec3;

// The paper's parameters: how errors of colour are spread over [0, 1] and how features weigh.
constexpr double color_exponent = 0.7;       // qc
constexpr double knee_of_range = 0.4;        // pc: errors up to this part of the largest …
constexpr double knee_value = 0.95;          // pt: … fill this part of [0, 1]
constexpr double feature_exponent = 0.5;     // qf
constexpr double feature_width = 0.082;      // w: degrees, the width of an edge that is seen best
constexpr double widest_sensitivity = 0.04;  // the largest b of the sensitivity functions below

// ------------------------------------------------------------------------------------------------- spaces of colour
// Linear Rec.709 with white D65 to XYZ and back.
dmat3 to_xyz() {
    return glm::transpose(dmat3(10135552.0 / 24577794, 8788810.0 / 24577794, 4435075.0 / 24577794,  //
                                2613072.0 / 12288897, 8788810.0 / 12288897, 887015.0 / 12288897,    //
                                1425312.0 / 73733382, 8788810.0 / 73733382, 70074185.0 / 73733382));
}

// L*a*b* without its cube roots: linear in light, so that filtering in it is filtering light; Y carries lightness, Cx
// red to green, Cz yellow to blue.
dvec3 ycxcz_of_xyz(dvec3 xyz, dvec3 white) {
    const dvec3 v = xyz / white;
    return {116 * v.y - 16, 500 * (v.x - v.y), 200 * (v.y - v.z)};
}
dvec3 xyz_of_ycxcz(dvec3 c, dvec3 white) {
    const double y = (c.x + 16) / 116;
    return dvec3(y + c.y / 500, y, y - c.z / 200) * white;
}

dvec3 lab_of_xyz(dvec3 xyz, dvec3 white) {
    const auto f = [](double t) {
        constexpr double delta = 6.0 / 29;
        return t > delta * delta * delta ? std::cbrt(t) : t / (3 * delta * delta) + 4.0 / 29;
    };
    const dvec3 v = xyz / white;
    return {116 * f(v.y) - 16, 500 * (f(v.x) - f(v.y)), 200 * (f(v.y) - f(v.z))};
}

// Colours look less colourful where it is dark (Hunt 1952).
dvec3 hunt_adjusted(dvec3 lab) { return {lab.x, 0.01 * lab.x * lab.y, 0.01 * lab.x * lab.z}; }

// For large differences of colour (Abasi et al. 2020).
double hyab(dvec3 a, dvec3 b) { return std::abs(a.x - b.x) + std::hypot(a.y - b.y, a.z - b.z); }

// ---------------------------------------------------------------------------------------------------------- filters
// Odd-sized row of weights about its middle.
using Row = std::vector<double>;

Row gaussian(int radius, double exponent_scale) {
    Row row;
    for (int x = -radius; x <= radius; ++x) row.push_back(std::exp(-double(x * x) * exponent_scale));
    return row;
}
double sum(const Row& row) {
    double total = 0;
    for (const double w : row) total += w;
    return total;
}
Row normalised(Row row) {
    const double total = sum(row);
    for (double& w : row) w /= total;
    return row;
}
// Positive weights sum to 1 and negative ones to −1, so that a full edge or point gives 1.
Row balanced(Row row) {
    double positive = 0, negative = 0;
    for (const double w : row) (w > 0 ? positive : negative) += w;
    for (double& w : row) w /= w > 0 ? positive : -negative;
    return row;
}

struct Plane {
    int width = 0;
    int height = 0;
    std::vector<double> values;
};

// Rows along x, then along y. Beyond the border its pixels go on.
Plane filtered(const Plane& plane, const Row& along_x, const Row& along_y) {
    Plane between = plane, result = plane;
    const auto pass = [&](const Plane& from, Plane& to, const Row& row, bool horizontal) {
        const int radius = int(row.size()) / 2;
        parallel_for(std::size_t(plane.height), 8, [&](std::size_t begin, std::size_t end) {
            for (int y = int(begin); y < int(end); ++y)
                for (int x = 0; x < plane.width; ++x) {
                    double total = 0;
                    for (int k = -radius; k <= radius; ++k) {
                        const int i = horizontal ? std::clamp(x + k, 0, plane.width - 1) : x;
                        const int j = horizontal ? y : std::clamp(y + k, 0, plane.height - 1);
                        total += row[std::size_t(k) + std::size_t(radius)] *
                                 from.values[std::size_t(j) * std::size_t(plane.width) + std::size_t(i)];
                    }
                    to.values[std::size_t(y) * std::size_t(plane.width) + std::size_t(x)] = total;
                }
        });
    };
    pass(plane, between, along_x, true);
    pass(between, result, along_y, false);
    return result;
}

// What the eye resolves of a channel: a sum of Gaussians a·exp(−b·f²) over frequency, here over space.
struct Sensitivity {
    double a1, b1, a2, b2;
};
constexpr Sensitivity sensitivities[] = {{1, 0.0047, 0, 1e-5}, {1, 0.0053, 0, 1e-5}, {34.1, 0.04, 13.5, 0.025}};

Plane seen(const Plane& plane, const Sensitivity& s, double pixels_per_degree) {
    const double pi2 = std::numbers::pi * std::numbers::pi;
    const int radius = int(std::ceil(3 * std::sqrt(widest_sensitivity / (2 * pi2)) * pixels_per_degree));
    const double degrees2 = 1 / (pixels_per_degree * pixels_per_degree);
    const Row first = gaussian(radius, pi2 / s.b1 * degrees2);
    if (s.a2 == 0) return filtered(plane, normalised(first), normalised(first));
    // A sum of two is not separable, each of them is; the sum of all weights is 1.
    const Row second = gaussian(radius, pi2 / s.b2 * degrees2);
    const double share1 = s.a1 * std::sqrt(std::numbers::pi / s.b1) * sum(first) * sum(first);
    const double share2 = s.a2 * std::sqrt(std::numbers::pi / s.b2) * sum(second) * sum(second);
    Plane result = filtered(plane, normalised(first), normalised(first));
    const Plane other = filtered(plane, normalised(second), normalised(second));
    for (std::size_t i = 0; i < result.values.size(); ++i)
        result.values[i] = (share1 * result.values[i] + share2 * other.values[i]) / (share1 + share2);
    return result;
}

// What is compared of one picture.
struct Perceived {
    std::vector<dvec3> color;  // Hunt-adjusted L*a*b* of what the eye resolves
    std::vector<double> edge;  // magnitudes of the features of lightness
    std::vector<double> point;
};

Perceived perceived(const Image& image, double pixels_per_degree) {
    const dmat3 xyz = to_xyz(), rgb = glm::inverse(xyz);
    const dvec3 white = xyz * dvec3(1);
    const std::size_t count = std::size_t(image.width) * std::size_t(image.height);
    Plane channels[3];
    for (Plane& plane : channels) plane = {image.width, image.height, std::vector<double>(count)};
    for (std::size_t i = 0; i < count; ++i) {
        const float* value = image.values.data() + i * std::size_t(image.channels);
        dvec3 linear;
        for (int c = 0; c < 3; ++c)
            linear[c] = double(srgb_decoded(std::clamp(value[image.channels == 1 ? 0 : c], 0.0f, 1.0f)));
        const dvec3 color = ycxcz_of_xyz(xyz * linear, white);
        for (int c = 0; c < 3; ++c) channels[c].values[i] = color[c];
    }

    Perceived result;
    const Plane y = seen(channels[0], sensitivities[0], pixels_per_degree);
    const Plane cx = seen(channels[1], sensitivities[1], pixels_per_degree);
    const Plane cz = seen(channels[2], sensitivities[2], pixels_per_degree);
    result.color.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
        const dvec3 linear = rgb * xyz_of_ycxcz({y.values[i], cx.values[i], cz.values[i]}, white);
        result.color[i] = hunt_adjusted(lab_of_xyz(xyz * glm::clamp(linear, dvec3(0), dvec3(1)), white));
    }

    // Edges by the first, points by the second derivative of a Gaussian, on lightness from 0 to 1.
    Plane lightness = channels[0];
    for (double& v : lightness.values) v = (v + 16) / 116;
    const double deviation = 0.5 * feature_width * pixels_per_degree;
    const int radius = int(std::ceil(3 * deviation));
    const Row smooth = gaussian(radius, 0.5 / (deviation * deviation));
    Row first = smooth, second = smooth;
    for (int x = -radius; x <= radius; ++x) {
        const std::size_t i = std::size_t(x) + std::size_t(radius);
        first[i] *= -x;
        second[i] *= double(x * x) / (deviation * deviation) - 1;
    }
    const auto magnitude = [&](const Row& derivative) {
        const Row row = balanced(derivative), across = normalised(smooth);
        const Plane x = filtered(lightness, row, across), z = filtered(lightness, across, row);
        std::vector<double> values(count);
        for (std::size_t i = 0; i < count; ++i) values[i] = std::hypot(x.values[i], z.values[i]);
        return values;
    };
    result.edge = magnitude(first);
    result.point = magnitude(second);
    return result;
}

// The largest difference of colour there is, between green and blue, after the exponent.
double largest_color_error() {
    const dmat3 xyz = to_xyz();
    const dvec3 white = xyz * dvec3(1);
    const auto adjusted = [&](dvec3 linear) { return hunt_adjusted(lab_of_xyz(xyz * linear, white)); };
    return std::pow(hyab(adjusted({0, 1, 0}), adjusted({0, 0, 1})), color_exponent);
}

// Small differences take most of [0, 1], the rare large ones what is left.
double redistributed(double error, double largest) {
    const double knee = knee_of_range * largest;
    if (error < knee) return error * knee_value / knee;
    return std::min(knee_value + (error - knee) / (largest - knee) * (1 - knee_value), 1.0);
}

}  // namespace

Result<Image> flip_map(const Image& image, const Image& reference, double pixels_per_degree) {
    if (Result<void> comparable = check_comparable(image, reference); !comparable) return comparable.error();
    if (image.channels != 1 && image.channels != 3)
        return Error{"FLIP compares pictures of 1 or 3 channels, these have " + std::to_string(image.channels)};
    for (const Image* picture : {&image, &reference})
        for (const float v : picture->values)
            if (std::isnan(v)) return Error{"FLIP compares what is seen, and a picture holds NaN"};
    const Perceived a = perceived(image, pixels_per_degree), b = perceived(reference, pixels_per_degree);
    const double largest = largest_color_error();
    Image map{image.width, image.height, 1, std::vector<float>(a.color.size())};
    for (std::size_t i = 0; i < map.values.size(); ++i) {
        const double color = redistributed(std::pow(hyab(a.color[i], b.color[i]), color_exponent), largest);
        const double difference = std::max(std::abs(a.edge[i] - b.edge[i]), std::abs(a.point[i] - b.point[i]));
        const double feature = std::min(std::pow(difference / std::numbers::sqrt2, feature_exponent), 1.0);
        map.values[i] = float(std::pow(color, 1 - feature));
    }
    return map;
}

Result<double> flip(const Image& image, const Image& reference, double pixels_per_degree) {
    const Result<Image> map = flip_map(image, reference, pixels_per_degree);
    if (!map) return map.error();
    return channel_means(*map)[0];
}

}  // namespace spinel
