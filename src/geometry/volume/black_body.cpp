// Planck's law weighted by the CIE 1931 observer, by the fits of Wyman, Sloan, Shirley, "Simple Analytic Approximations
// to the CIE XYZ Color Matching Functions", JCGT 2(2), 2013, every 5 nm from 380 to 780.
#include "geometry/volume/black_body.h"

#include <algorithm>
#include <cmath>

namespace spinel {
namespace {

using glm::dvec3;

double lobe(double x, double centre, double below, double above) {
    const double t = (x - centre) * (x < centre ? below : above);
    return std::exp(-0.5 * t * t);
}

dvec3 observer(double nm) {
    return {1.056 * lobe(nm, 599.8, 0.0264, 0.0323) + 0.362 * lobe(nm, 442.0, 0.0624, 0.0374) -
                0.065 * lobe(nm, 501.1, 0.0490, 0.0382),
            0.821 * lobe(nm, 568.8, 0.0213, 0.0247) + 0.286 * lobe(nm, 530.9, 0.0613, 0.0322),
            1.217 * lobe(nm, 437.0, 0.0845, 0.0278) + 0.681 * lobe(nm, 459.0, 0.0385, 0.0725)};
}

// XYZ divided by a constant that is the same for all temperatures.
dvec3 planck_xyz(double kelvin) {
    dvec3 sum(0);
    if (!(kelvin > 0)) return sum;
    for (int nm = 380; nm <= 780; nm += 5) {
        const double l = 1e-3 * nm;                                       // micrometres
        const double exponent = 14387.768775 / (l * kelvin);              // hc / (λ k T)
        sum += observer(nm) / (std::pow(l, 5.0) * std::expm1(exponent));  // overflows to a radiance of 0
    }
    return sum;
}

}  // namespace

glm::vec3 black_body(float kelvin, float reference) {
    const dvec3 xyz = planck_xyz(kelvin);
    const double luminance = planck_xyz(reference).y;
    if (!(luminance > 0)) return glm::vec3(0);
    const dvec3 rgb(3.2404542 * xyz.x - 1.5371385 * xyz.y - 0.4985314 * xyz.z,
                    -0.9692660 * xyz.x + 1.8760108 * xyz.y + 0.0415560 * xyz.z,
                    0.0556434 * xyz.x - 0.2040259 * xyz.y + 1.0572252 * xyz.z);
    return glm::vec3(glm::min(glm::max(rgb, dvec3(0)) / luminance, dvec3(1e30)));
}

}  // namespace spinel
