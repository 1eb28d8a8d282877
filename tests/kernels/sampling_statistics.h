#pragma once
// Statistics for tests of samplers: do samples follow the density that is claimed for them?

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "kernels/constants.h"

namespace spinel::test {

// Chance that a chi-square variable exceeds x: the regularised upper incomplete gamma function Q(degrees/2,
// x/2), by its series or its continued fraction (Lentz), whichever converges.
inline double chi_square_p_value(double x, int degrees) {
    const double a = 0.5 * degrees, z = 0.5 * x;
    if (!(z > 0)) return 1;
    const double front = std::exp(-z + a * std::log(z) - std::lgamma(a));
    if (z < a + 1) {
        double term = 1 / a, sum = term;
        for (int n = 1; n < 10000 && term > sum * 1e-16; ++n) sum += term *= z / (a + n);
        return 1 - front * sum;
    }
    double b = z + 1 - a, c = 1e300, d = 1 / b, h = d;
    for (int n = 1; n < 10000; ++n) {
        const double an = -n * (n - a);
        b += 2;
        d = 1 / (an * d + b);
        c = b + an / c;
        h *= d * c;
        if (std::abs(d * c - 1) < 1e-15) break;
    }
    return front * h;
}

// The p-value below which one of `count` tests may fail for the whole family to err once in a thousand
// (Šidák).
inline double sidak_threshold(int count) { return 1 - std::pow(1 - 1e-3, 1.0 / count); }

// Pearson's test. Bins that expect fewer than five are pooled. Returns the p-value; 0 where something fell
// into bins that expect nothing.
inline double chi_square_test(const std::vector<double>& observed, const std::vector<double>& expected) {
    double statistic = 0, pooled_observed = 0, pooled_expected = 0;
    int degrees = -1;
    for (std::size_t i = 0; i < observed.size(); ++i) {
        if (expected[i] < 5) {
            pooled_observed += observed[i];
            pooled_expected += expected[i];
            continue;
        }
        const double difference = observed[i] - expected[i];
        statistic += difference * difference / expected[i];
        ++degrees;
    }
    if (pooled_expected >= 1) {
        const double difference = pooled_observed - pooled_expected;
        statistic += difference * difference / pooled_expected;
        ++degrees;
    } else if (pooled_observed > 10) {
        return 0;
    }
    if (degrees < 1) return statistic < 20 ? 1 : 0;
    return chi_square_p_value(statistic, degrees);
}

// ∫∫ f over a rectangle: 3×3 Gauss–Legendre, split where splitting changes the result.
inline double integrate(const std::function<double(double, double)>& f, double x0, double x1, double y0, double y1,
                        double tolerance, int max_depth = 9, int depth = 0) {
    auto gauss = [&](double ax, double bx, double ay, double by) {
        static constexpr double node[3] = {-0.7745966692414834, 0, 0.7745966692414834};
        static constexpr double weight[3] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
        double sum = 0;
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) {
                sum += weight[i] * weight[j] *
                       f(0.5 * (ax + bx) + 0.5 * (bx - ax) * node[i], 0.5 * (ay + by) + 0.5 * (by - ay) * node[j]);
            }
        }
        return sum * (bx - ax) * (by - ay);
    };
    const double xm = 0.5 * (x0 + x1), ym = 0.5 * (y0 + y1);
    const double whole = gauss(x0, x1, y0, y1);
    const double split = gauss(x0, xm, y0, ym) + gauss(xm, x1, y0, ym) + gauss(x0, xm, ym, y1) + gauss(xm, x1, ym, y1);
    if (depth >= 2 && (std::abs(whole - split) <= tolerance || depth >= max_depth)) return split;
    return integrate(f, x0, xm, y0, ym, tolerance / 2, max_depth, depth + 1) +
           integrate(f, xm, x1, y0, ym, tolerance / 2, max_depth, depth + 1) +
           integrate(f, x0, xm, ym, y1, tolerance / 2, max_depth, depth + 1) +
           integrate(f, xm, x1, ym, y1, tolerance / 2, max_depth, depth + 1);
}

// Histogram over the sphere by z and φ, and what a density predicts for it. Samples without a direction
// (failures, delta lobes) go into a bin of their own, which must get what the density leaves.
class SphereChiSquare {
  public:
    SphereChiSquare(int z_bins, int phi_bins)
        : z_bins_(z_bins), phi_bins_(phi_bins), observed_(std::size_t(z_bins * phi_bins) + 1, 0.0) {}

    void add(glm::vec3 direction) {
        const double z = std::clamp(double(direction.z), -1.0, 1.0);
        double phi = std::atan2(double(direction.y), double(direction.x)) / (2 * M_PI);
        if (phi < 0) phi += 1;
        const int i = std::min(int((z + 1) / 2 * z_bins_), z_bins_ - 1);
        const int j = std::min(int(phi * phi_bins_), phi_bins_ - 1);
        observed_[std::size_t(i * phi_bins_ + j)] += 1;
        count_ += 1;
    }
    void add_without_direction() {
        observed_.back() += 1;
        count_ += 1;
    }

    // pdf per solid angle. dω = dz dφ.
    double p_value(const std::function<double(glm::vec3)>& pdf, int max_depth = 9) {
        std::vector<double> expected;
        double sum = 0;
        auto f = [&](double z, double phi) {
            const double r = std::sqrt(std::max(0.0, 1 - z * z));
            return pdf(glm::vec3(float(r * std::cos(phi)), float(r * std::sin(phi)), float(z)));
        };
        for (int i = 0; i < z_bins_; ++i) {
            for (int j = 0; j < phi_bins_; ++j) {
                const double mass =
                    integrate(f, 2.0 * i / z_bins_ - 1, 2.0 * (i + 1) / z_bins_ - 1, 2 * M_PI * j / phi_bins_,
                              2 * M_PI * (j + 1) / phi_bins_, 0.1 / count_, max_depth);
                expected.push_back(mass * count_);
                sum += mass;
            }
        }
        integral_ = sum;
        expected.push_back(std::max(0.0, (1 - sum) * count_));
        return chi_square_test(observed_, expected);
    }
    double integral() const { return integral_; }

  private:
    int z_bins_, phi_bins_;
    std::vector<double> observed_;
    double count_ = 0;
    double integral_ = 0;
};

// 1/|J| of a map from the unit square to directions, by central differences: the density that the map really
// has.
inline double density_of_direction_map(const std::function<glm::dvec3(double, double)>& map, double u, double v,
                                       double step) {
    const glm::dvec3 du = (map(u + step, v) - map(u - step, v)) / (2 * step);
    const glm::dvec3 dv = (map(u, v + step) - map(u, v - step)) / (2 * step);
    return 1 / glm::length(glm::cross(du, dv));
}

}  // namespace spinel::test
