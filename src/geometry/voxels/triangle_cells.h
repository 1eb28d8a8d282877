#pragma once
// Which cells of a lattice a triangle touches. Conservative: a cell counts when its closed cube and the triangle share
// a point, so a closed mesh gives a shell that no ray passes.
//
// Separating axes of triangle and box (Akenine-Möller, "Fast 3D Triangle-Box Overlap Testing", JGT 6(1), 2001), in the
// form of Schwarz and Seidel ("Fast Parallel Surface and Solid Voxelization on GPUs", SIGGRAPH Asia 2010): the cell
// must be cut by the plane, and in each of the three projections lie on the inner side of every edge. Along the axis
// that the normal is nearest to, the plane itself tells which cells to ask, so that the work grows with the area.

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

namespace spinel {

class TriangleCells {
  public:
    // In the cells' space. Cells are larger by `margin` on every side.
    TriangleCells(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, double margin = 0)
        : lower_(glm::min(a, glm::min(b, c)) - margin),
          upper_(glm::max(a, glm::max(b, c)) + margin),
          normal_(glm::cross(b - a, c - a)) {
        const double length = glm::length(normal_);
        // Of a triangle without area, what fused multiplication leaves of the product is no direction: a segment has no
        // plane, its edges say all.
        if (length > 1e-14 * glm::length(b - a) * glm::length(c - a)) normal_ /= length;
        else normal_ = glm::dvec3(0);
        glm::dvec3 far_corner, near_corner;
        for (int i = 0; i < 3; ++i) {
            far_corner[i] = normal_[i] > 0 ? 1 : 0;
            near_corner[i] = 1 - far_corner[i];
            if (std::abs(normal_[i]) > std::abs(normal_[main_])) main_ = i;
        }
        const double reach = margin * (std::abs(normal_.x) + std::abs(normal_.y) + std::abs(normal_.z)) + slack;
        plane_upper_ = glm::dot(normal_, far_corner - a) + reach;
        plane_lower_ = glm::dot(normal_, near_corner - a) - reach;
        const glm::dvec3 vertices[3] = {a, b, c};
        for (int axis = 0; axis < 3; ++axis) {
            const int u = (axis + 1) % 3, v = (axis + 2) % 3;
            const double sign = normal_[axis] >= 0 ? 1 : -1;
            for (int i = 0; i < 3; ++i) {
                const glm::dvec3 from = vertices[i], edge = vertices[(i + 1) % 3] - from;
                glm::dvec2 n = sign * glm::dvec2(-edge[v], edge[u]);
                const double size = glm::length(n);
                if (size > 0) n /= size;
                const double wide = std::max(0.0, n.x) + std::max(0.0, n.y);
                edges_[axis][i] = {n, -glm::dot(n, glm::dvec2(from[u], from[v])) + wide +
                                          margin * (std::abs(n.x) + std::abs(n.y)) + slack};
            }
        }
    }

    // visit(cell) for the cells within begin ≤ cell < end.
    template <class Visit>
    void for_each(glm::ivec3 begin, glm::ivec3 end, const Visit& visit) const {
        glm::ivec3 first, last;
        for (int i = 0; i < 3; ++i) {
            first[i] = std::max(begin[i], int(std::max(std::floor(lower_[i] - slack), -1.0)));
            last[i] = int(std::min(std::floor(upper_[i] + slack), double(end[i]) - 1));
        }
        const int w = main_, u = (w + 1) % 3, v = (w + 2) % 3;
        glm::ivec3 cell;
        for (cell[v] = first[v]; cell[v] <= last[v]; ++cell[v])
            for (cell[u] = first[u]; cell[u] <= last[u]; ++cell[u]) {
                if (!meets_projection(w, cell)) continue;
                int from = first[w], to = last[w];
                if (normal_[w] != 0) {
                    const double d = normal_[u] * cell[u] + normal_[v] * cell[v];
                    double p = -(d + plane_lower_) / normal_[w], q = -(d + plane_upper_) / normal_[w];
                    if (p > q) std::swap(p, q);
                    from = std::max(from, int(std::ceil(std::max(p - slack, -1.0))));
                    to = std::min(to, int(std::floor(std::min(q + slack, double(last[w])))));
                }
                for (cell[w] = from; cell[w] <= to; ++cell[w])
                    if (meets_projection(u, cell) && meets_projection(v, cell)) visit(cell);
            }
    }

  private:
    // Far above the rounding of doubles and far below a cell: what merely touches counts.
    static constexpr double slack = 1e-7;
    struct Edge {
        glm::dvec2 normal;
        double offset;
    };

    bool meets_projection(int axis, glm::ivec3 cell) const {
        const double x = cell[(axis + 1) % 3], y = cell[(axis + 2) % 3];
        for (const Edge& edge : edges_[axis])
            if (edge.normal.x * x + edge.normal.y * y + edge.offset < 0) return false;
        return true;
    }

    glm::dvec3 lower_, upper_, normal_;
    double plane_lower_, plane_upper_;
    int main_ = 0;
    Edge edges_[3][3];
};

}  // namespace spinel
