#include "accel/grid_builder.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/parallel.h"
#include "kernels/mesh_grid.h"

namespace spinel {
namespace {

constexpr int finest_refinement = 64;   // cells along an axis of a grid within a cell
constexpr float smallest_cell = 3e-5f;  // of the largest coordinate: 256 times what floats tell apart there

double half_area(const glm::dvec3& e) { return e.x * e.y + e.y * e.z + e.z * e.x; }

struct Entry {
    std::uint32_t cell;
    std::uint32_t primitive;
};

class Builder {
  public:
    Builder(std::span<const Box> boxes, const CellsOfPrimitive& cells_of, const GridOptions& options)
        : boxes_(boxes), cells_of_(cells_of), options_(options) {
        largest_ = 0;
        for (const Box& box : boxes)
            for (int a = 0; a < 3; ++a) largest_ = std::max({largest_, std::abs(box.lower[a]), std::abs(box.upper[a])});
    }

    Grid3 build() {
        Box bounds = boxes_[0];
        for (const Box& box : boxes_) {
            bounds.lower = glm::min(bounds.lower, box.lower);
            bounds.upper = glm::max(bounds.upper, box.upper);
        }
        std::vector<std::uint32_t> all(boxes_.size());
        std::iota(all.begin(), all.end(), 0u);
        out_.words.push_back(0);
        out_.grids.resize(1);
        finest_ = glm::vec3(kernels::INFINITE);
        const double area = half_area(glm::dvec3(bounds.upper - bounds.lower));
        const double cost = fill(0, choose(bounds, all.size(), kernels::GRID_MAX_CELLS), all, 0);
        out_.sah_cost = area > 0 ? cost / area : cost;
        out_.words[0] = std::uint32_t(out_.grids.size());
        out_.grids.push_back({bounds.lower, 0, finest_, 1.0f / finest_, glm::ivec3(1)});
        put_in_order();
        return std::move(out_);
    }

  private:
    // About as many cells as the density says, as near to cubes as that lets them be.
    CellGrid choose(const Box& bounds, std::size_t count, int most) const {
        glm::dvec3 extent = glm::dvec3(bounds.upper) - glm::dvec3(bounds.lower);
        const double longest =
            std::max({extent.x, extent.y, extent.z, double(largest_) * double(smallest_cell), 1e-30});
        extent = glm::max(extent, glm::dvec3(1e-3 * longest));
        // A flat thing has no volume to share out: the axis along which it is thin gets one layer.
        double edge = std::cbrt(extent.x * extent.y * extent.z / (options_.density * double(count)));
        for (int pass = 0; pass < 2; ++pass) {
            double volume = 1;
            int axes = 0;
            for (int a = 0; a < 3; ++a)
                if (extent[a] > edge) volume *= extent[a], ++axes;
            if (axes > 0) edge = std::pow(volume / (options_.density * double(count)), 1.0 / axes);
        }
        edge = std::max(edge, double(largest_) * double(smallest_cell));
        CellGrid grid{};
        for (int a = 0; a < 3; ++a) {
            grid.size[a] = std::clamp(int(extent[a] / edge + 0.5), 1, most);
            grid.cell[a] = float(std::max(extent[a] / grid.size[a], double(largest_) * double(smallest_cell)));
            const double middle = 0.5 * (double(bounds.lower[a]) + double(bounds.upper[a]));
            grid.lower[a] = float(middle - 0.5 * double(grid.cell[a]) * grid.size[a]);
        }
        return grid;
    }

    std::vector<Entry> entries_of(const CellGrid& grid, const std::vector<std::uint32_t>& primitives) const {
        // In chunks that do not depend on the number of threads.
        constexpr std::size_t chunk = 4096;
        std::vector<std::vector<Entry>> parts((primitives.size() + chunk - 1) / chunk);
        parallel_for(parts.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t part = begin; part < end; ++part)
                for (std::size_t i = part * chunk; i < std::min(primitives.size(), (part + 1) * chunk); ++i)
                    cells_of_(primitives[i], grid, [&](glm::ivec3 c) {
                        parts[part].push_back(
                            {std::uint32_t(c.x + grid.size.x * (c.y + grid.size.y * c.z)), primitives[i]});
                    });
        });
        if (parts.size() == 1) return std::move(parts[0]);
        std::vector<Entry> entries;
        for (const auto& part : parts) entries.insert(entries.end(), part.begin(), part.end());
        return entries;
    }

    // Fills grid `index` with what is there; returns its cost times its half area.
    double fill(std::size_t index, const CellGrid& grid, const std::vector<std::uint32_t>& primitives,
                std::uint32_t level) {
        finest_ = glm::min(finest_, grid.cell);
        out_.depth = std::max(out_.depth, level);
        const auto cell_count = std::size_t(grid.size.x) * std::size_t(grid.size.y) * std::size_t(grid.size.z);
        const std::size_t cell_first = out_.words.size();
        out_.words.resize(cell_first + cell_count, 0);
        out_.grids[index] = {grid.lower, std::uint32_t(cell_first), grid.cell, 1.0f / grid.cell, grid.size};
        const std::vector<Entry> entries = entries_of(grid, primitives);
        std::vector<std::uint32_t> first(cell_count + 1, 0), sorted(entries.size());
        for (const Entry& e : entries) ++first[e.cell + 1];
        std::partial_sum(first.begin(), first.end(), first.begin());
        std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
        for (const Entry& e : entries) sorted[next[e.cell]++] = e.primitive;
        const double area = half_area(grid.cell);
        double cost = 0;
        for (std::size_t c = 0; c < cell_count; ++c) {
            const std::size_t count = first[c + 1] - first[c];
            cost += area * double(options_.step_cost);
            if (count == 0) continue;
            const std::vector<std::uint32_t> list(sorted.begin() + first[c], sorted.begin() + first[c + 1]);
            const double plain = area * double(count);
            if (options_.refine_above > 0 && count > options_.refine_above && level + 1 < kernels::GRID_MAX_LEVELS) {
                if (const double refined = refine(grid, cell_first + c, c, list, level, plain); refined < plain) {
                    cost += refined;
                    continue;
                }
            }
            out_.words[cell_first + c] = std::uint32_t(out_.words.size());
            list_firsts_.push_back(out_.words.size());
            out_.words.push_back(std::uint32_t(count));
            out_.words.insert(out_.words.end(), list.begin(), list.end());
            ++out_.list_count;
            cost += plain;
        }
        return cost;
    }

    // Makes a cell, which stands at `word`, a grid, if that is cheaper than its list.
    double refine(const CellGrid& grid, std::size_t word, std::size_t cell, const std::vector<std::uint32_t>& list,
                  std::uint32_t level, double plain) {
        const auto x = int(cell % std::size_t(grid.size.x)), yz = int(cell / std::size_t(grid.size.x));
        const glm::vec3 place(float(x), float(yz % grid.size.y), float(yz / grid.size.y));
        const glm::vec3 lower = grid.lower + place * grid.cell;
        const CellGrid inner = choose({lower, lower + grid.cell}, list.size(), finest_refinement);
        if (inner.size == glm::ivec3(1)) return plain;
        const Saved before{out_.words.size(), out_.grids.size(), list_firsts_.size(),
                           out_.list_count,   out_.depth,        finest_};
        const std::size_t index = out_.grids.size();
        out_.grids.emplace_back();
        const double cost = fill(index, inner, list, level + 1);
        // As much must be gained as the way into the grid costs.
        if (!(cost + half_area(grid.cell) * 4 * double(options_.step_cost) < plain)) {
            restore(before);
            return plain;
        }
        out_.words[word] = kernels::GRID_REFINED | std::uint32_t(index);
        return cost;
    }

    struct Saved {
        std::size_t words, grids, lists, list_count;
        std::uint32_t depth;
        glm::vec3 finest;
    };
    void restore(const Saved& s) {
        out_.words.resize(s.words);
        out_.grids.resize(s.grids);
        list_firsts_.resize(s.lists);
        out_.list_count = s.list_count;
        out_.depth = s.depth;
        finest_ = s.finest;
    }

    // Places of primitives in the order of their first list, and lists of places.
    void put_in_order() {
        constexpr std::uint32_t none = ~0u;
        std::vector<std::uint32_t> place(boxes_.size(), none);
        out_.order.reserve(boxes_.size());
        for (const std::size_t first : list_firsts_)
            for (std::size_t i = first + 1; i <= first + out_.words[first]; ++i) {
                std::uint32_t& p = place[out_.words[i]];
                if (p == none) {
                    p = std::uint32_t(out_.order.size());
                    out_.order.push_back(out_.words[i]);
                }
                out_.words[i] = p;
            }
        for (std::size_t i = 0; i < place.size(); ++i)  // none, unless cells_of broke its promise
            if (place[i] == none) out_.order.push_back(std::uint32_t(i));
    }

    std::span<const Box> boxes_;
    const CellsOfPrimitive& cells_of_;
    const GridOptions options_;
    float largest_;
    glm::vec3 finest_;
    Grid3 out_;
    std::vector<std::size_t> list_firsts_;
};

}  // namespace

Grid3 build_grid(std::span<const Box> boxes, const CellsOfPrimitive& cells_of, const GridOptions& options) {
    if (boxes.empty()) return {};
    return Builder(boxes, cells_of, options).build();
}

}  // namespace spinel
