#include "accel/pair_tree.h"

namespace spinel::bvh {
namespace {

using Node = PairTree::Node;

class Finisher {
  public:
    Finisher(const PairTree& tree, const std::vector<Primitive>& primitives, const BvhOptions& options)
        : tree_(tree), primitives_(primitives), options_(options), counts_(tree.nodes.size()) {
        price();
    }

    Bvh finish() {
        std::vector<kernels::BvhNode> sparse(2 * primitives_.size());
        struct Pending {
            std::uint32_t node;  // of the tree
            std::size_t to;      // in sparse
            int depth;
        };
        std::vector<Pending> stack = {{tree_.root, 0, 0}};
        std::size_t pool = 1;
        while (!stack.empty()) {
            const Pending p = stack.back();
            stack.pop_back();
            const Node& node = tree_.nodes[p.node];
            const std::uint32_t count = counts_[p.node].primitives;
            kernels::BvhNode& out = sparse[p.to];
            set_bounds(out, node.bounds);
            if (counts_[p.node].is_leaf) {
                out.first = std::uint32_t(order_.size());
                out.count = count;
                gather(p.node);
                continue;
            }
            if (p.depth + ceil_log2(count) >= int(kernels::BVH_MAX_DEPTH)) {
                const std::size_t begin = order_.size();
                gather(p.node);
                halve(sparse, p.to, pool, begin, order_.size());
                continue;
            }
            out.first = std::uint32_t(pool);
            out.count = 0;
            pool += 2;
            stack.push_back({node.right, out.first + std::size_t(1), p.depth + 1});
            stack.push_back({node.left, out.first, p.depth + 1});
        }
        Bvh bvh;
        compact(sparse, options_.traversal_cost, bvh);
        bvh.order.reserve(order_.size());
        for (const std::uint32_t i : order_) bvh.order.push_back(primitives_[i].index);
        return bvh;
    }

  private:
    struct Count {
        std::uint32_t primitives = 0;
        float cost = 0;  // by half areas
        bool is_leaf = false;
    };

    static void set_bounds(kernels::BvhNode& out, const Bounds& b) {
        out.lower = {b.lower[0], b.lower[1], b.lower[2]};
        out.upper = {b.upper[0], b.upper[1], b.upper[2]};
    }

    // From below: what each subtree costs, and whether it is cheaper as one leaf.
    void price() {
        std::vector<std::uint32_t> down = {tree_.root};
        for (std::size_t i = 0; i < down.size(); ++i) {
            const Node& node = tree_.nodes[down[i]];
            if (node.is_leaf()) continue;
            down.push_back(node.left);
            down.push_back(node.right);
        }
        for (std::size_t i = down.size(); i-- > 0;) {
            const Node& node = tree_.nodes[down[i]];
            Count& c = counts_[down[i]];
            const float area = node.bounds.half_area();
            if (node.is_leaf()) {
                c = {1, area, true};
                continue;
            }
            const Count &l = counts_[node.left], &r = counts_[node.right];
            c.primitives = l.primitives + r.primitives;
            c.cost = options_.traversal_cost * area + l.cost + r.cost;
            const float as_leaf = area * float(c.primitives);
            if (c.primitives <= options_.max_leaf && as_leaf <= c.cost) c = {c.primitives, as_leaf, true};
        }
    }

    void gather(std::uint32_t root) {
        std::vector<std::uint32_t> stack = {root};
        while (!stack.empty()) {
            const Node& node = tree_.nodes[stack.back()];
            stack.pop_back();
            if (node.is_leaf()) {
                order_.push_back(node.left);
                continue;
            }
            stack.push_back(node.right);
            stack.push_back(node.left);
        }
    }

    void halve(std::vector<kernels::BvhNode>& sparse, std::size_t to, std::size_t& pool, std::size_t begin,
               std::size_t end) {
        Bounds bounds = Bounds::empty();
        for (std::size_t i = begin; i < end; ++i) bounds.extend(primitives_[order_[i]].bounds);
        set_bounds(sparse[to], bounds);
        if (end - begin <= options_.max_leaf) {
            sparse[to].first = std::uint32_t(begin);
            sparse[to].count = std::uint32_t(end - begin);
            return;
        }
        const std::size_t children = pool;
        pool += 2;
        sparse[to].first = std::uint32_t(children);
        sparse[to].count = 0;
        const std::size_t middle = begin + (end - begin) / 2;
        halve(sparse, children, pool, begin, middle);
        halve(sparse, children + 1, pool, middle, end);
    }

    const PairTree& tree_;
    const std::vector<Primitive>& primitives_;
    const BvhOptions& options_;
    std::vector<Count> counts_;
    std::vector<std::uint32_t> order_;
};

}  // namespace

PairTree pair_tree(const Bvh& bvh) {
    PairTree tree;
    tree.root = 0;
    tree.nodes.resize(bvh.nodes.size());
    for (std::uint32_t i = 0; i < bvh.nodes.size(); ++i) {
        const kernels::BvhNode& n = bvh.nodes[i];
        Node& node = tree.nodes[i];
        node.bounds = {{n.lower.x, n.lower.y, n.lower.z, 0}, {n.upper.x, n.upper.y, n.upper.z, 0}};
        node.left = n.first;
        if (n.count > 0) continue;
        node.right = n.first + 1;
        tree.nodes[n.first].parent = tree.nodes[n.first + 1].parent = i;
    }
    return tree;
}

Bvh finish(const PairTree& tree, const std::vector<Primitive>& primitives, const BvhOptions& options) {
    return Finisher(tree, primitives, options).finish();
}

}  // namespace spinel::bvh
