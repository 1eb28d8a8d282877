#pragma once
// A hierarchy of spheres with the topology of a BVH of boxes (kernels/mesh_spheres.h).

#include <functional>
#include <span>
#include <vector>

#include "accel/bvh_builder.h"

namespace spinel {

// How far the farthest point of a primitive, by its place in the order, lies from a point.
using FarthestPoint = std::function<double(std::uint32_t place, const glm::dvec3& from)>;

// Each ball stands about the middle of its node's box, just large enough for what is below it.
std::vector<kernels::SphereNode> sphere_nodes(std::span<const kernels::BvhNode> nodes, const FarthestPoint& farthest);

// Expected primitive tests of a ray that meets the root's ball: chances go by areas of spheres.
double sphere_cost(std::span<const kernels::SphereNode> nodes, float traversal_cost);

}  // namespace spinel
