#include "accel/grid_builder.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>
#include <optional>

#include "core/parallel.h"
#include "kernels/mesh_grid.h"

namespace spinel {
namespace {

constexpr int finest_refinement = 64;  // cells along an axis of a grid within a cell
// Of the largest coordinate: whatever lies within the mesh is in kernels::GRID_REACH then, even if the mesh is centred.
constexpr float smallest_cell = 6.2e-5f;
constexpr std::size_t most_references = std::size_t(1) << 30;
constexpr std::size_t growth_of_cell = 8;  // references of a grid within a cell, by those of the cell

double half_area(const glm::dvec3& e) { return e.x * e.y + e.y * e.z + e.z * e.x; }

struct Entry {
    std::uint32_t cell;
    std::uint32_t primitive;
};

class Builder {
  public:
    Builder(std::span<const Box> boxes, const CellsOfPrimitive& cells_of, const GridOptions& options)
        : boxes_(boxes), cells_of_(cells_of), options_(options) {
        spare_ = std::min(options.references * boxes.size() + (std::size_t(1) << 20), most_references);
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
        const double area = half_area(glm::dvec3(bounds.upper - bounds.lower));
        // Coarser, where each of many primitives lies in very many cells; the coarsest grid has one cell. And where
        // cells may be refined, not so fine along a short axis that rays from outside are soon out of reach.
        double density = options_.density;
        const glm::vec3 extent = bounds.upper - bounds.lower;
        const double edge = options_.refine_above > 0
                                ? double(std::max({extent.x, extent.y, extent.z})) / kernels::GRID_MAX_CELLS
                                : 0.0;
        CellGrid grid = choose(bounds, density * double(all.size()), kernels::GRID_MAX_CELLS, edge);
        auto entries = entries_of(grid, all, spare_);
        for (; !entries; entries = entries_of(grid, all, spare_)) {
            density /= 8;
            grid = choose(bounds, density * double(all.size()), kernels::GRID_MAX_CELLS, edge);
        }
        spare_ -= std::min(spare_, entries->size());
        const double cost = fill(0, grid, std::move(*entries), 0);
        out_.sah_cost = area > 0 ? cost / area : cost;
        out_.words[0] = std::uint32_t(out_.grids.size());
        put_in_order();
        return std::move(out_);
    }

  private:
    // About so many cells, at least one, as near to cubes as that lets them be, of edges of about `shortest` at least.
    CellGrid choose(const Box& bounds, double count, int most, double shortest) const {
        glm::dvec3 extent = glm::dvec3(bounds.upper) - glm::dvec3(bounds.lower);
        const double longest =
            std::max({extent.x, extent.y, extent.z, double(largest_) * double(smallest_cell), 1e-30});
        extent = glm::max(extent, glm::dvec3(1e-3 * longest));
        // A flat thing has no volume to share out: the axis along which it is thin gets one layer.
        double edge = std::cbrt(extent.x * extent.y * extent.z / count);
        for (int pass = 0; pass < 2; ++pass) {
            double volume = 1;
            int axes = 0;
            for (int a = 0; a < 3; ++a)
                if (extent[a] > edge) volume *= extent[a], ++axes;
            if (axes > 0) edge = std::pow(volume / count, 1.0 / axes);
        }
        edge = std::max({edge, shortest, double(largest_) * double(smallest_cell)});
        CellGrid grid{};
        for (int a = 0; a < 3; ++a) {
            grid.size[a] = std::clamp(int(std::lround(extent[a] / edge)), 1, most);
            grid.cell[a] = float(std::max(extent[a] / grid.size[a], double(largest_) * double(smallest_cell)));
            const double middle = 0.5 * (double(bounds.lower[a]) + double(bounds.upper[a]));
            grid.lower[a] = float(middle - 0.5 * double(grid.cell[a]) * grid.size[a]);
        }
        return grid;
    }

    // Which primitives lie in which cells; none if these are more than `most`.
    std::optional<std::vector<Entry>> entries_of(const CellGrid& grid, std::span<const std::uint32_t> primitives,
                                                 std::size_t most) const {
        // In chunks that do not depend on the number of threads.
        constexpr std::size_t chunk = 4096;
        std::vector<std::vector<Entry>> parts((primitives.size() + chunk - 1) / chunk);
        std::atomic<std::size_t> found = 0;
        parallel_for(parts.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t part = begin; part < end; ++part)
                for (std::size_t i = part * chunk; i < std::min(primitives.size(), (part + 1) * chunk); ++i) {
                    if (found.load(std::memory_order_relaxed) > most) return;
                    const std::size_t before = parts[part].size();
                    cells_of_(primitives[i], grid, [&](glm::ivec3 c) {
                        parts[part].push_back(
                            {std::uint32_t(c.x + grid.size.x * (c.y + grid.size.y * c.z)), primitives[i]});
                    });
                    found += parts[part].size() - before;
                }
        });
        if (found > most) return std::nullopt;
        if (parts.size() == 1) return std::move(parts[0]);
        std::vector<Entry> entries;
        for (const auto& part : parts) entries.insert(entries.end(), part.begin(), part.end());
        return entries;
    }

    // Fills grid `index` with what is there; returns its cost times its half area.
    double fill(std::size_t index, const CellGrid& grid, std::vector<Entry>&& entries, std::uint32_t level) {
        out_.depth = std::max(out_.depth, level);
        const auto cell_count = std::size_t(grid.size.x) * std::size_t(grid.size.y) * std::size_t(grid.size.z);
        const std::size_t cell_first = out_.words.size();
        out_.words.resize(cell_first + cell_count, 0);
        out_.grids[index] = {grid.lower, std::uint32_t(cell_first), grid.cell, 1.0f / grid.cell, grid.size};
        std::vector<std::uint32_t> first(cell_count + 1, 0), sorted(entries.size());
        for (const Entry& e : entries) ++first[e.cell + 1];
        std::partial_sum(first.begin(), first.end(), first.begin());
        std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
        for (const Entry& e : entries) sorted[next[e.cell]++] = e.primitive;
        entries = {};
        const double area = half_area(grid.cell);
        double cost = 0;
        for (std::size_t c = 0; c < cell_count; ++c) {
            const std::size_t count = first[c + 1] - first[c];
            cost += area * double(options_.step_cost);
            if (count == 0) continue;
            const std::span<const std::uint32_t> list(sorted.data() + first[c], count);
            if (options_.refine_above > 0 && count > options_.refine_above && level + 1 < kernels::GRID_MAX_LEVELS) {
                if (const auto refined = refine(grid, cell_first + c, c, list, level)) {
                    cost += *refined;
                    continue;
                }
            }
            const std::uint32_t place = append(list);
            out_.words[cell_first + c] = place;
            ++out_.list_count;
            cost += area * double(count);
        }
        return cost;
    }

    // Says where the list begins among the words.
    std::uint32_t append(std::span<const std::uint32_t> list) {
        const std::size_t first = out_.words.size();
        list_firsts_.push_back(first);
        out_.words.push_back(std::uint32_t(list.size()));
        out_.words.insert(out_.words.end(), list.begin(), list.end());
        return std::uint32_t(first);
    }

    // Makes a cell, which stands at `word`, a grid, if that is cheaper than its list even if no cell of it is refined
    // in turn; tells its cost then. Decided before anything is filled, so that what is given up costs little.
    std::optional<double> refine(const CellGrid& grid, std::size_t word, std::size_t cell,
                                 std::span<const std::uint32_t> list, std::uint32_t level) {
        const auto x = int(cell % std::size_t(grid.size.x)), yz = int(cell / std::size_t(grid.size.x));
        const glm::ivec3 place(x, yz % grid.size.y, yz / grid.size.y);
        const glm::vec3 lower = grid.lower + glm::vec3(place) * grid.cell;
        const CellGrid inner =
            choose({lower, lower + grid.cell}, options_.density * double(list.size()), finest_refinement, 0);
        if (inner.size == glm::ivec3(1)) return std::nullopt;
        auto entries = entries_of(inner, list, std::min(growth_of_cell * list.size(), spare_));
        if (!entries) return std::nullopt;
        const double cells = double(inner.size.x) * double(inner.size.y) * double(inner.size.z);
        const double estimate = half_area(inner.cell) * (cells * double(options_.step_cost) + double(entries->size()));
        // As much must be gained as the way into the grid costs.
        const double area = half_area(grid.cell);
        if (!(estimate + area * 4 * double(options_.step_cost) < area * double(list.size()))) return std::nullopt;
        spare_ -= entries->size();
        const std::size_t index = out_.grids.size();
        out_.grids.emplace_back();
        const std::size_t whole = out_.words.size();
        out_.words.push_back(0);
        const double cost = fill(index, inner, std::move(*entries), level + 1);
        const std::uint32_t first =
            append(list);  // for rays from so far away that they cannot tell the inner cells apart
        out_.words[whole] = first;
        out_.words[word] = kernels::GRID_REFINED | std::uint32_t(index);
        return cost;
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
    std::size_t spare_;  // references that may still be added
    float largest_;
    Grid3 out_;
    std::vector<std::size_t> list_firsts_;
};

}  // namespace

Grid3 build_grid(std::span<const Box> boxes, const CellsOfPrimitive& cells_of, const GridOptions& options) {
    if (boxes.empty()) return {};
    return Builder(boxes, cells_of, options).build();
}

}  // namespace spinel
