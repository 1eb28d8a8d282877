#pragma once
// The tree of a grid in NanoVDB's layout, read without trust: nodes are only seen through offsets that lie within the
// grid's bytes.

#include <nanovdb/NanoVDB.h>

#include <algorithm>
#include <optional>
#include <string>
#include <unordered_map>
#include <unordered_set>

#include "spinel/grid.h"

namespace spinel {

inline float nano_component(float v, int) { return v; }
inline float nano_component(double v, int) { return float(v); }
template <class T>
float nano_component(const nanovdb::Vec3<T>& v, int i) {
    return float(v[i]);
}

template <class BuildT>
class NanoTree {
  public:
    using Leaf = nanovdb::NanoLeaf<BuildT>;
    using LeafData = typename Leaf::DataType;
    using Value = typename Leaf::ValueType;

    // What is wrong, if anything is.
    std::optional<std::string> read(const char* bytes, std::size_t size) {
        bytes_ = bytes, size_ = size;
        constexpr const char* damaged = "is damaged: it refers beyond its end";
        const auto* tree = at<nanovdb::TreeData<3>>(sizeof(nanovdb::GridData));
        if (!tree || tree->mNodeOffset[3] > size) return damaged;
        const std::size_t root_at = sizeof(nanovdb::GridData) + tree->mNodeOffset[3];
        const auto* root = at<Root>(root_at);
        if (!root) return damaged;
        background_ = root->mBackground;
        const std::size_t tiles_at = root_at + sizeof(Root);
        if (root->mTableSize > (size - tiles_at) / sizeof(typename Root::Tile)) return damaged;
        budget_ = size / 32;
        for (std::uint32_t i = 0; i < root->mTableSize; ++i) {
            const auto* tile = at<typename Root::Tile>(tiles_at + i * sizeof(typename Root::Tile));
            if (!tile) return damaged;
            const Coord origin = Root::KeyToCoord(tile->key);
            if (tile->child == 0) {
                // Only what differs from the background takes part.
                if (tile->state) return "has active tiles of 4096 voxels";
                continue;
            }
            if (!read_upper(root_at, tile->child, origin)) return damaged;
        }
        return {};
    }

    bool empty() const { return lower_[0] > upper_[0]; }
    ivec3 lower() const { return lower_; }
    ivec3 upper() const { return upper_; }  // the last active voxel
    Value background() const { return background_; }

    // As a BrickFiller: the brick whose first voxel is `first`, a multiple of 8.
    int fill(ivec3 first, int channels, std::span<float> samples) const {
        constexpr auto volume = GridSamples::brick_volume;
        const auto brick = bricks_.find(key(first, 3));
        if (brick != bricks_.end() && brick->second.leaf) {
            for (std::uint32_t i = 0; i < volume; ++i) {
                const std::size_t x = i >> 6, y = i >> 3 & 7, z = i & 7;  // a leaf runs z fastest
                const Value value = brick->second.leaf->getValue(i);
                for (int c = 0; c < channels; ++c)
                    samples[std::size_t(c) * volume + (x | y << 3 | z << 6)] = nano_component(value, c);
            }
            return 0;
        }
        Value value = background_;
        if (brick != bricks_.end()) value = brick->second.value;
        else if (const auto tile = tiles_.find(key(first, 7)); tile != tiles_.end()) value = tile->second;
        for (int c = 0; c < channels; ++c) samples[std::size_t(c) * volume] = nano_component(value, c);
        // Where no node divides 128 voxels, they are alike.
        return divided_.contains(key(first, 7)) ? 1 : 16 - (first.x >> 3 & 15);
    }

  private:
    using Coord = nanovdb::Coord;
    using Root = nanovdb::RootData<nanovdb::NanoUpper<BuildT>>;
    using UpperNode = nanovdb::NanoUpper<BuildT>;
    using LowerNode = nanovdb::NanoLower<BuildT>;
    using Upper = typename UpperNode::DataType;
    using Lower = typename LowerNode::DataType;
    struct Brick {
        const LeafData* leaf = nullptr;
        Value value = {};
    };

    static std::uint64_t key(ivec3 v, int shift) {
        const auto bits = [&](int x) { return std::uint64_t(std::uint32_t(x >> shift)) & 0x1fffffu; };
        return bits(v.x) | bits(v.y) << 21 | bits(v.z) << 42;
    }

    template <class T>
    const T* at(std::size_t offset) const {
        if (offset > size_ || sizeof(T) > size_ - offset || offset % alignof(T) != 0) return nullptr;
        return reinterpret_cast<const T*>(bytes_ + offset);
    }
    // Where a child stands, or beyond everything.
    std::size_t moved(std::size_t from, std::int64_t by) const {
        const std::int64_t to = std::int64_t(from) + std::clamp<std::int64_t>(by, -(1LL << 60), 1LL << 60);
        return to < 0 ? ~std::size_t(0) : std::size_t(to);
    }
    // Nodes are not more than the bytes have room for, however often one is named.
    bool take() { return budget_ > 0 && budget_-- > 0; }

    void widen(ivec3 lower, ivec3 upper) {
        lower_ = glm::min(lower_, lower);
        upper_ = glm::max(upper_, upper);
    }
    static ivec3 vec(const Coord& c) { return {c[0], c[1], c[2]}; }

    bool read_upper(std::size_t parent, std::int64_t offset, const Coord& origin) {
        const std::size_t place = moved(parent, offset);
        const auto* node = at<Upper>(place);
        if (!node || !take()) return false;
        for (std::uint32_t i = 0; i < UpperNode::SIZE; ++i) {
            const Coord local = UpperNode::OffsetToLocalCoord(i);
            const Coord here(origin[0] + (local[0] << 7), origin[1] + (local[1] << 7), origin[2] + (local[2] << 7));
            if (node->mChildMask.isOn(i)) {
                if (!read_lower(place, node->mTable[i].child, here)) return false;
                continue;
            }
            const Value value = node->mTable[i].value;
            if (value != background_) tiles_[key(vec(here), 7)] = value;
            if (node->mValueMask.isOn(i)) widen(vec(here), vec(here) + 127);
        }
        return true;
    }

    bool read_lower(std::size_t parent, std::int64_t offset, const Coord& origin) {
        const std::size_t place = moved(parent, offset);
        const auto* node = at<Lower>(place);
        if (!node || !take()) return false;
        divided_.insert(key(vec(origin), 7));
        for (std::uint32_t i = 0; i < LowerNode::SIZE; ++i) {
            const Coord local = LowerNode::OffsetToLocalCoord(i);
            const ivec3 here(origin[0] + (local[0] << 3), origin[1] + (local[1] << 3), origin[2] + (local[2] << 3));
            if (node->mChildMask.isOn(i)) {
                if (!read_leaf(place, node->mTable[i].child, here)) return false;
                continue;
            }
            const Value value = node->mTable[i].value;
            if (value != background_) bricks_[key(here, 3)] = {nullptr, value};
            if (node->mValueMask.isOn(i)) widen(here, here + 7);
        }
        return true;
    }

    bool read_leaf(std::size_t parent, std::int64_t offset, ivec3 origin) {
        const std::size_t place = moved(parent, offset);
        const auto* leaf = at<LeafData>(place);
        if (!leaf || !take()) return false;
        if constexpr (!LeafData::FIXED_SIZE) {  // FpN: the codes stand behind
            if ((leaf->mFlags >> 5) > 4 || leaf->memUsage() > size_ - place) return false;
        }
        bricks_[key(origin, 3)] = {leaf, {}};
        for (std::uint32_t i = 0; i < 512; ++i) {
            if (!leaf->mValueMask.isOn(i)) continue;
            const ivec3 voxel = origin + ivec3(int(i >> 6), int(i >> 3 & 7), int(i & 7));
            widen(voxel, voxel);
        }
        return true;
    }

    const char* bytes_ = nullptr;
    std::size_t size_ = 0, budget_ = 0;
    Value background_ = {};
    ivec3 lower_ = ivec3(1 << 30), upper_ = ivec3(-(1 << 30));
    std::unordered_map<std::uint64_t, Brick> bricks_;
    std::unordered_map<std::uint64_t, Value> tiles_;
    std::unordered_set<std::uint64_t> divided_;  // places of tiles that nodes take
};

}  // namespace spinel
