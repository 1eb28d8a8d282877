// Where surfaces of two instances may lie in the same place, so that kernels ask for the others there and nowhere else
// (kernels/boundary.h). A pair counts if one of the two has an inside: between two walls there is nothing to sort out.
//
// Everything here is a box in world space that holds more than it must: a contact too many costs a short query for each
// ray that meets a surface there, one too few a wrong picture.
#include <algorithm>
#include <cmath>
#include <span>

#include "kernels/mesh_wide.h"
#include "kernels/sdf.h"
#include "scene/boxes.h"
#include "scene/compilation.h"

namespace spinel {
namespace {

using kernels::uint;
using Shape = Compilation::Shape;

const Box everywhere{vec3(-1e30f), vec3(1e30f)};

// Adds what of a piece's bounds lies in the region.
void add_piece(Box& found, const Box& piece, const Box& region) {
    const Box part = intersection(piece, region);
    if (!is_empty(part)) found = hull(found, part);
}

struct Placed {
    const kernels::Instance& instance;
    const Shape& shape;
};

bool contains(const Box& outer, const Box& inner) {
    return glm::all(glm::lessThanEqual(outer.lower, inner.lower)) &&
           glm::all(glm::lessThanEqual(inner.upper, outer.upper));
}

// Calls visit(triangle, an index in the mesh) for all triangles in leaves of a binary tree, into whose nodes it is
// asked whether to go; an empty order: triangles stand in the order of the leaves.
template <class Enter, class Visit>
void visit_binary(std::span<const kernels::BvhNode> nodes, std::span<const uint> order, const Enter& enter,
                  const Visit& visit) {
    std::vector<uint> pending{0};
    while (!pending.empty()) {
        const kernels::BvhNode& node = nodes[pending.back()];
        pending.pop_back();
        if (!enter(Box{node.lower, node.upper})) continue;
        if (node.count == 0) {
            pending.push_back(node.first);
            pending.push_back(node.first + 1);
            continue;
        }
        for (uint i = node.first; i < node.first + node.count; ++i) visit(order.empty() ? i : order[i]);
    }
}

// The same of a wide tree. Its leaves may bound a part of a triangle each.
template <class Enter, class Visit>
void visit_wide(const kernels::WideUnit* units, const Enter& enter, const Visit& visit) {
    std::vector<uint> pending{0};
    while (!pending.empty()) {
        const uint reference = pending.back();
        pending.pop_back();
        const kernels::WideUnit* unit = units + (reference & kernels::WIDE_UNIT_MASK);
        if (uint blocks = reference >> 28; blocks > 0) {
            for (; blocks > 0; --blocks, unit += kernels::WIDE_BLOCK_UNITS)
                for (uint lane = 0; lane < 4; ++lane) visit(kernels::float_bits(unit[4].lanes[4 + lane]));
            continue;
        }
        for (int i = 0; i < 8; ++i) {
            const Box box{{unit[0].lanes[i], unit[2].lanes[i], unit[4].lanes[i]},
                          {unit[1].lanes[i], unit[3].lanes[i], unit[5].lanes[i]}};
            if (box.lower.x <= box.upper.x && enter(box)) pending.push_back(kernels::float_bits(unit[6].lanes[i]));
        }
    }
}

// By the mesh's own tree, or, where it has none of boxes, by one that is made here.
template <class Enter, class Visit>
void visit_triangles(Compilation& c, uint index, const Enter& enter, const Visit& visit) {
    const kernels::Mesh& mesh = c.out.meshes[index];
    if (mesh.walk == kernels::MESH_WALK_WIDE) return visit_wide(&c.out.wide_units[mesh.node_first], enter, visit);
    if (mesh.walk == kernels::MESH_WALK_BVH2)
        return visit_binary(std::span(c.out.nodes).subspan(mesh.node_first), {}, enter, visit);
    Bvh& made = c.mesh_bounds[index];
    if (made.nodes.empty()) {
        std::vector<Box> boxes;
        for (const kernels::Triangle& t : std::span(c.out.triangles).subspan(mesh.triangle_first, mesh.triangle_count))
            boxes.push_back({glm::min(t.a, glm::min(t.b, t.c)), glm::max(t.a, glm::max(t.b, t.c))});
        made = build_bvh(boxes);
    }
    visit_binary(made.nodes, made.order, enter, visit);
}

// Bounds of a mesh's triangles that come near the region.
Box mesh_within(Compilation& c, const kernels::Instance& instance, const Box& local, const Box& region) {
    const kernels::Mesh& mesh = c.out.meshes[instance.geometry];
    const mat4x3& to_world = instance.object_to_world;
    Box found = empty_box;
    const auto enter = [&](const Box& box) {
        // Where nothing can widen what is found there is no need to look: large meshes take a moment only.
        return !is_empty(intersection(box, local)) &&
               !contains(found, intersection(world_bounds(to_world, box.lower, box.upper), region));
    };
    visit_triangles(c, instance.geometry, enter, [&](uint triangle) {
        const kernels::Triangle& t = c.out.triangles[mesh.triangle_first + triangle];
        Box piece = empty_box;
        for (const vec3& corner : {t.a, t.b, t.c}) piece = hull(piece, world_bounds(to_world, corner, corner));
        add_piece(found, piece, region);
    });
    return found;
}

// Bounds of an instance's surface within a region; empty if there is none.
Box surface_within(Compilation& c, const Placed& placed, const Box& region) {
    const CompiledScene& scene = c.out;
    const kernels::Instance& instance = placed.instance;
    // A region may be thinner than the rounding of the way to local space and back.
    const float pad = kernels::ROUNDING_ERROR *
                      (magnitude(region) + magnitude({instance.object_to_world[3], instance.object_to_world[3]}));
    const Box wide = grown(region, pad);
    const Box local = world_bounds(instance.world_to_object, wide.lower, wide.upper);
    const mat4x3& to_world = instance.object_to_world;
    Box found = empty_box;
    switch (instance.geometry_kind) {
        case kernels::GEOMETRY_MESH: return mesh_within(c, instance, local, region);
        case kernels::GEOMETRY_BOX:
            for (int face = 0; face < 6; ++face) {
                vec3 lower(-1), upper(1);
                lower[face / 2] = upper[face / 2] = face % 2 ? 1.0f : -1.0f;
                add_piece(found, grown(world_bounds(to_world, lower, upper), pad), region);
            }
            return found;
        case kernels::GEOMETRY_RECTANGLE:
            add_piece(found, grown(world_bounds(to_world, {-1, 0, -1}, {1, 0, 1}), pad), region);
            return found;
        case kernels::GEOMETRY_PLANE: {
            if (local.lower.y > 0 || local.upper.y < 0) return found;
            const vec3 lower(local.lower.x, 0, local.lower.z), upper(local.upper.x, 0, local.upper.z);
            add_piece(found, grown(world_bounds(to_world, lower, upper), pad), region);
            return found;
        }
        case kernels::GEOMETRY_SPHERE: {
            const vec3 nearest = glm::clamp(vec3(0), local.lower, local.upper);
            const vec3 farthest = glm::max(glm::abs(local.lower), glm::abs(local.upper));
            if (glm::length(nearest) > 1.00001f || glm::length(farthest) < 0.99999f) return found;
            break;
        }
        case kernels::GEOMETRY_SDF: {
            const kernels::Sdf& sdf = scene.sdfs[instance.geometry];
            const vec3 center = 0.5f * (local.lower + local.upper);
            const float radius = 0.5f * glm::length(local.upper - local.lower);
            const bool bounded =
                glm::all(glm::lessThan(sdf.lower, local.lower)) && glm::all(glm::lessThan(local.upper, sdf.upper));
            if (bounded && std::abs(kernels::sdf_distance(scene.view(), instance.geometry, center)) >
                               1.001f * sdf.lipschitz * radius)
                return found;
            break;
        }
        default: break;
    }
    add_piece(found, grown(world_bounds(to_world, placed.shape.lower, placed.shape.upper), pad), region);
    return found;
}

// Bound of the rounding error of positions on an instance's surface within a region: that of surface_at().
float position_error(const Placed& placed, const Box& region) {
    const mat4x3& m = placed.instance.object_to_world;
    if (placed.shape.bounded) return bounded_position_error(m, placed.shape.lower, placed.shape.upper);
    const float offset = kernels::max_component(glm::abs(m[3]));
    return kernels::ROUNDING_ERROR * (2 * offset + magnitude(region));  // of an endless plane, as far as the region
}

// Two planes that are one, up to rounding.
bool same_plane(const kernels::Instance& a, const kernels::Instance& b) {
    const vec3 normal = glm::normalize(vec3(0, 1, 0) * kernels::mat3(a.world_to_object));
    const vec3 other = glm::normalize(vec3(0, 1, 0) * kernels::mat3(b.world_to_object));
    const vec3 apart = b.object_to_world[3] - a.object_to_world[3];
    const float size = glm::length(a.object_to_world[3]) + glm::length(b.object_to_world[3]);
    return std::abs(glm::dot(normal, other)) > 1 - 1e-6f && std::abs(glm::dot(apart, normal)) <= 1e-5f * size;
}

struct Finder {
    Compilation& c;
    std::vector<Box> bounds = {};  // of bounded instances
    std::vector<std::vector<kernels::Contact>> contacts =
        std::vector<std::vector<kernels::Contact>>(c.out.instances.size());

    Placed placed(uint i) const { return {c.out.instances[i], c.shapes[std::size_t(c.scene.objects[i].geometry)]}; }

    bool has_inside(uint i) const {
        const Placed p = placed(i);
        for (std::size_t s = 0; s < p.shape.slot_count; ++s)
            if (c.out.slots[p.instance.slot_first + s].interior != kernels::NONE) return true;
        return false;
    }

    // Contacts of an instance share a box if their errors are alike: few boxes to look through, and a large error far
    // away says nothing of what is near.
    void add_contact(uint i, const Box& where, float error) {
        for (kernels::Contact& contact : contacts[i]) {
            if (std::ilogb(contact.error) / 2 != std::ilogb(error) / 2) continue;
            const Box all = hull({contact.lower, contact.upper}, where);
            contact = {all.lower, all.upper, std::max(contact.error, error)};
            return;
        }
        contacts[i].push_back({where.lower, where.upper, error});
    }

    Result<void> write_contacts() {
        for (uint i = 0; i < contacts.size(); ++i) {
            const Result<uint> first = append_pool(c.out.contacts, contacts[i], "contacts of objects");
            if (!first) return first.error();
            c.out.instances[i].contact_first = *first;
            c.out.instances[i].contact_count = uint(contacts[i].size());
        }
        return {};
    }

    void meet(uint a, uint b) {
        const Placed pa = placed(a), pb = placed(b);
        Box shared = everywhere;
        if (pa.shape.bounded) shared = intersection(shared, bounds[a]);
        if (pb.shape.bounded) shared = intersection(shared, bounds[b]);
        Box where = everywhere;
        float error = 0;  // of planes: what grows with the distance is in Surface::error
        if (pa.shape.bounded || pb.shape.bounded) {
            // A mesh is asked last, about as little as possible.
            if (pa.instance.geometry_kind == kernels::GEOMETRY_MESH) std::swap(a, b);
            error = std::max(position_error(placed(a), shared), position_error(placed(b), shared));
            where = surface_within(c, placed(a), grown(shared, 2 * error));
            if (!is_empty(where)) where = surface_within(c, placed(b), grown(where, 2 * error));
            if (is_empty(where)) return;
            where = grown(where, 2 * error);
        } else if (!same_plane(pa.instance, pb.instance)) {
            return;
        } else {
            error = std::max(std::max(position_error(pa, {vec3(0), vec3(0)}), position_error(pb, {vec3(0), vec3(0)})),
                             1e-30f);
        }
        add_contact(a, where, error);
        add_contact(b, where, error);
    }
};

}  // namespace

float bounded_position_error(const mat4x3& m, vec3 lower, vec3 upper) {
    const vec3 sum = glm::abs(m[0]) + glm::abs(m[1]) + glm::abs(m[2]);
    const vec3 extent = glm::max(glm::abs(lower), glm::abs(upper));
    return kernels::ROUNDING_ERROR *
           (kernels::max_component(sum) * kernels::max_component(extent) + kernels::max_component(glm::abs(m[3])));
}

Result<void> find_contacts(Compilation& c) {
    CompiledScene& out = c.out;
    Finder finder{c};
    std::vector<bool> inside;
    float largest_error = 0;
    for (uint i = 0; i < out.instances.size(); ++i) {
        const Placed p = finder.placed(i);
        inside.push_back(finder.has_inside(i));
        finder.bounds.push_back(world_bounds(p.instance.object_to_world, p.shape.lower, p.shape.upper));
        if (p.shape.bounded) largest_error = std::max(largest_error, position_error(p, finder.bounds[i]));
    }
    // The other is told only once of a pair in which both have an inside.
    const auto is_pair = [&](uint a, uint b) { return a != b && inside[a] && (a < b || !inside[b]); };
    std::vector<uint> pending;
    for (uint a = 0; a < out.bounded_count; ++a) {
        const uint i = out.instance_order[a];
        if (!inside[i]) continue;
        const Box near = grown(finder.bounds[i], 4 * largest_error);
        pending.assign(1, 0);
        while (!pending.empty()) {
            const kernels::BvhNode& node = out.instance_nodes[pending.back()];
            pending.pop_back();
            if (is_empty(intersection({node.lower, node.upper}, near))) continue;
            if (node.count == 0) {
                pending.push_back(node.first);
                pending.push_back(node.first + 1);
            }
            for (uint k = node.first; node.count > 0 && k < node.first + node.count; ++k)
                if (is_pair(i, out.instance_order[k])) finder.meet(i, out.instance_order[k]);
        }
    }
    for (uint p = out.bounded_count; p < out.instance_order.size(); ++p)
        for (uint k = 0; k < p; ++k) {
            const uint plane = out.instance_order[p], other = out.instance_order[k];
            if (inside[plane] || inside[other]) finder.meet(plane, other);
        }
    return finder.write_contacts();
}

}  // namespace spinel
