// Rays in no order against a set of voxels. Eight of them, each at a place of its own, take their steps together, one
// in each lane of a register; where a ray ends, the next one of the batch takes its lane. What a ray alone must wait
// for (its node, the plane that it meets first, its next cell) eight wait for at once, and no branch depends on one.
//
// The steps are those of voxel_walk.cpp, with one skip more: where no child of a node is occupied that the ray could
// still come to, the ones on its side of all three axes, it goes to the exit of the node. All skips lead to the same
// cells at the same t (kernels/voxels.h), so the hits are the kernel's, bit for bit. Which cell comes next is guessed
// from the position; where that is in doubt by rounding, the kernel's own function decides.
//
// Rays that start in something, or where rounding is about a cell, go one by one.

#include <algorithm>
#include <cstddef>

#include "devices/cpu/ray_columns.h"
#include "kernels/device.h"

#ifdef SPINEL_AVX2
SPINEL_AVX2_AS_ELSEWHERE_BEGIN

namespace spinel {

namespace {

using namespace kernels;

constexpr int lanes = packet_size;
constexpr unsigned every_lane = (1u << lanes) - 1;
constexpr uint nowhere = 3;  // axis of a ray that has not taken a step

__m256i ints(int x) { return _mm256_set1_epi32(x); }
__m256 floats(float x) { return _mm256_set1_ps(x); }
__m256i choose(__m256i a, __m256i b, __m256i second) { return _mm256_blendv_epi8(a, b, second); }
__m256 choose(__m256 a, __m256 b, __m256 second) { return _mm256_blendv_ps(a, b, second); }
__m256i load(const void* at) { return _mm256_load_si256(static_cast<const __m256i*>(at)); }
void store(void* at, __m256i x) { _mm256_store_si256(static_cast<__m256i*>(at), x); }

// Bits that are set in a or b.
__m256i popcount(__m256i a, __m256i b) {
#if defined(__AVX512VPOPCNTDQ__) && defined(__AVX512VL__)
    return _mm256_add_epi32(_mm256_popcnt_epi32(a), _mm256_popcnt_epi32(b));
#else
    const __m256i of_nibble =
        _mm256_broadcastsi128_si256(_mm_setr_epi8(0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4));
    const __m256i nibble = _mm256_set1_epi8(15);
    const auto bytes = [&](__m256i x) {
        return _mm256_add_epi8(_mm256_shuffle_epi8(of_nibble, _mm256_and_si256(x, nibble)),
                               _mm256_shuffle_epi8(of_nibble, _mm256_and_si256(_mm256_srli_epi16(x, 4), nibble)));
    };
    const __m256i sums = _mm256_add_epi8(bytes(a), bytes(b));
    return _mm256_madd_epi16(_mm256_maddubs_epi16(sums, _mm256_set1_epi8(1)), _mm256_set1_epi16(1));
#endif
}

// What a ray is and where it begins. Along axes on which it stands still, planes are met at INFINITE =
// (0 − −INFINITE) · 1, and the position is the middle of its cell for ever.
struct Course {
    __m256 plane_origin[3], inverse[3];
    __m256 origin[3], direction[3];
    __m256i positive[3];  // −1 where the direction is
    __m256 sure;          // a position is about its cell if it is so near to its middle
    __m256 limit;
    __m256i ray;
    __m256i cell[3];
    __m256 t;
};
constexpr std::size_t course_columns = sizeof(Course) / sizeof(__m256);

struct Nodes {
    __m256i low, high, link;
};

Nodes choose(const Nodes& a, const Nodes& b, __m256i second) {
    return {choose(a.low, b.low, second), choose(a.high, b.high, second), choose(a.link, b.link, second)};
}

// Eight rays on their way.
struct Lanes {
    Course course;
    __m256i axis;                     // of the face that the ray came in by
    Nodes node;                       // the node that it is in …
    __m256i shift;                    // … and of coordinates to the digit of its children: two bits for each level
    __m256i stack[VOXEL_MAX_LEVELS];  // the numbers of the nodes above, by level
    unsigned live = 0;                // lanes whose ray is on its way …
    unsigned hit = 0;                 // … and those whose ray has met something
};

class Stream {
  public:
    Stream(const SceneView& scene, uint grid, uint slot_first, uint instance, std::span<const Ray> rays, Hit* hits)
        : scene_(scene),
          grid_index_(grid),
          slot_first_(slot_first),
          instance_(instance),
          grid_(scene.voxel_grids.at[grid]),
          rays_(rays),
          hits_(hits),
          top_shift_(2 * (int(grid_.level_count) - 1)) {
        // Lanes that are idle read some node; where there is none but the root, that one.
        const bool divided = (grid_.root.mask_low | grid_.root.mask_high) != 0 &&
                             (grid_.root.link & VOXEL_LINK_KIND) == VOXEL_LINK_CHILDREN;
        nodes_ = divided ? scene.voxel_nodes.at + grid_.node_first : &grid_.root;
        if (divided && grid_.reference_first != NONE) references_ = scene.words.at + grid_.reference_first;
        root_ = {ints(int(grid_.root.mask_low)), ints(int(grid_.root.mask_high)), ints(int(grid_.root.link))};
    }

    void run() {
        Lanes s = idle_lanes();
        for (;;) {
            if (s.live != every_lane && !refill(s)) return;
            step(s);
        }
    }

  private:
    // Rays that wait for a lane, a row for each number of a Course.
    struct Queue {
        alignas(32) float rows[course_columns][3 * lanes];
        int first = 0, end = 0;
    };

    Lanes idle_lanes() const {
        Lanes s;
        for (auto& row : s.stack) row = _mm256_setzero_si256();
        for (std::size_t i = 0; i < course_columns; ++i) (&s.course.plane_origin[0])[i] = _mm256_setzero_ps();
        s.node = root_;
        s.shift = ints(top_shift_);
        s.axis = ints(int(nowhere));
        return s;
    }

    void one_by_one(std::size_t i) {
        const float before = hits_[i].t;
        cpu_voxels_closest(scene_, grid_index_, slot_first_, rays_[i], hits_[i]);
        if (hits_[i].t < before) hits_[i].instance = instance_;
    }

    // Eight rays more wait for a lane, or those of them that meet the box.
    void prepare() {
        Ray some[lanes];
        const std::size_t count = std::min<std::size_t>(lanes, rays_.size() - next_ray_);
        const Ray* first = &rays_[next_ray_];
        if (count < lanes) {
            for (std::size_t i = 0; i < lanes; ++i) some[i] = first[std::min(i, count - 1)];
            first = some;
        }
        for (std::size_t i = 0; i < count; ++i) hits_[next_ray_ + i] = no_hit(first[i].t_max);
        const RayColumns ray = ray_columns(first);
        const BoxPass box = pass_box(grid_.size, ray, ray.t_max);
        const unsigned asked = (1u << count) - 1;
        const unsigned enters = lanes_of(_mm256_cmp_ps(box.start, box.leave, _CMP_LT_OQ)) & box.exact & asked;
        if (enters) append(begin(ray, box, first, enters), enters);
        for (unsigned rest = asked & ~box.exact; rest; rest &= rest - 1)
            one_by_one(next_ray_ + unsigned(std::countr_zero(rest)));
        next_ray_ += count;
    }

    Course begin(const RayColumns& ray, const BoxPass& box, const Ray* rays, unsigned enters) const {
        Course c;
        const __m256 doubt = _mm256_mul_ps(box.reach, floats(1e-6f));
        // At t = 0 the position is exact, and only what lies on a plane is in doubt.
        const __m256 here = _mm256_cmp_ps(box.start, _mm256_setzero_ps(), _CMP_EQ_OQ);
        const __m256 low = choose(doubt, floats(1e-18f), here);
        const __m256 high = choose(_mm256_sub_ps(floats(1), doubt), floats(1), here);
        __m256 sure = all_lanes();
        for (int a = 0; a < 3; ++a) {
            const __m256 position = _mm256_add_ps(
                ray.origin[a], _mm256_mul_ps(box.start, _mm256_andnot_ps(box.still[a], ray.direction[a])));
            const __m256i floor = _mm256_cvttps_epi32(_mm256_floor_ps(position));
            c.cell[a] = _mm256_max_epi32(_mm256_min_epi32(floor, ints(grid_.size[a] - 1)), ints(0));
            const __m256 fraction = _mm256_sub_ps(position, _mm256_cvtepi32_ps(c.cell[a]));
            sure = _mm256_and_ps(sure,
                                 _mm256_or_ps(box.still[a], _mm256_and_ps(_mm256_cmp_ps(fraction, low, _CMP_GE_OQ),
                                                                          _mm256_cmp_ps(fraction, high, _CMP_LE_OQ))));
        }
        if (unsigned doubtful = enters & ~lanes_of(sure)) [[unlikely]] {
            alignas(32) int cells[3][lanes];
            alignas(32) float start[lanes];
            for (int a = 0; a < 3; ++a) store(cells[a], c.cell[a]);
            _mm256_store_ps(start, box.start);
            for (; doubtful; doubtful &= doubtful - 1) {
                const int i = std::countr_zero(doubtful);
                const Ray& r = rays[i];
                for (int a = 0; a < 3; ++a)
                    cells[a][i] = voxel_cell(r.origin[a], r.direction[a], safe_inverse(r.direction[a]), start[i], true,
                                             0, grid_.size[a] - 1);
            }
            for (int a = 0; a < 3; ++a) c.cell[a] = load(cells[a]);
        }
        for (int a = 0; a < 3; ++a) {
            const __m256 middle = _mm256_add_ps(_mm256_cvtepi32_ps(c.cell[a]), floats(0.5f));
            c.plane_origin[a] = choose(ray.origin[a], floats(-INFINITE), box.still[a]);
            c.inverse[a] = choose(box.inverse[a], floats(1), box.still[a]);
            c.origin[a] = choose(ray.origin[a], middle, box.still[a]);
            c.direction[a] = _mm256_andnot_ps(box.still[a], ray.direction[a]);
            c.positive[a] = int_columns(box.positive[a]);
        }
        c.sure = _mm256_sub_ps(floats(0.5f), doubt);
        c.limit = ray.t_max;
        c.ray = _mm256_add_epi32(_mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7), ints(int(next_ray_)));
        c.t = box.start;
        return c;
    }

    void append(const Course& c, unsigned which) {
        const __m256i order = pack_order(which);
        for (std::size_t i = 0; i < course_columns; ++i)
            _mm256_storeu_ps(queue_.rows[i] + queue_.end, _mm256_permutevar8x32_ps((&c.plane_origin[0])[i], order));
        queue_.end += std::popcount(which);
    }

    // Gives idle lanes the next rays; false if there are neither rays nor lanes that walk.
    [[gnu::always_inline]] bool refill(Lanes& s) {
        if (s.hit) report(s);
        if (queue_.end - queue_.first < lanes && next_ray_ < rays_.size()) {
            for (auto& row : queue_.rows) _mm256_store_ps(row, _mm256_loadu_ps(row + queue_.first));
            queue_.end -= queue_.first;
            queue_.first = 0;
            while (queue_.end < lanes && next_ray_ < rays_.size()) prepare();
        }
        const unsigned idle = every_lane & ~s.live;
        const int count = std::min(queue_.end - queue_.first, std::popcount(idle));
        if (count == 0) return s.live != 0;
        const auto filled = unsigned(_pdep_u32((1u << count) - 1, idle));
        const __m256i order = spread_order(filled), mask = lane_mask(filled);
        for (std::size_t i = 0; i < course_columns; ++i) {
            __m256& column = (&s.course.plane_origin[0])[i];
            const __m256 next = _mm256_loadu_ps(queue_.rows[i] + queue_.first);
            column = choose(column, _mm256_permutevar8x32_ps(next, order), float_columns(mask));
        }
        s.node = choose(s.node, root_, mask);
        s.shift = choose(s.shift, ints(top_shift_), mask);
        s.axis = choose(s.axis, ints(int(nowhere)), mask);
        queue_.first += count;
        s.live |= filled;
        return true;
    }

    // What the rays of the lanes in s.hit have met.
    [[gnu::always_inline]] void report(Lanes& s) {
        alignas(32) uint cells[3][lanes], axes[lanes], low[lanes], high[lanes], link[lanes], shift[lanes], index[lanes];
        alignas(32) float t[lanes];
        for (int a = 0; a < 3; ++a) store(cells[a], s.course.cell[a]);
        store(axes, s.axis);
        store(low, s.node.low);
        store(high, s.node.high);
        store(link, s.node.link);
        store(shift, s.shift);
        store(index, s.course.ray);
        _mm256_store_ps(t, s.course.t);
        for (; s.hit; s.hit &= s.hit - 1) {
            const int i = std::countr_zero(s.hit);
            const ivec3 cell(cells[0][i], cells[1][i], cells[2][i]);
            const uint rank = popcount64(mask64_below(make_mask64(low[i], high[i]), voxel_digit(cell, shift[i] / 2)));
            const uint palette = voxel_palette(scene_, grid_, VoxelNode(low[i], high[i], link[i]), rank);
            if (axes[i] == nowhere || voxel_class(scene_, slot_first_, palette) == VOXEL_AIR) [[unlikely]] {
                one_by_one(index[i]);
                continue;
            }
            const Ray& ray = rays_[index[i]];
            Hit& hit = hits_[index[i]];
            voxel_hit(ray, t[i], cell, palette, axes[i], component(ray.direction, axes[i]) < 0.0f, hit);
            hit.instance = instance_;
        }
    }

    // Where each lane's cell is in its node, and whether anything is there.
    struct Look {
        __m256i digit[3];
        __m256i high;             // the sign tells which half of the mask the cell's bit is in …
        __m256i half;             // … which is this …
        __m256i bit;              // … and its number there
        __m256i occupied, inner;  // masks: there is something; the node's children are nodes
    };

    [[gnu::always_inline]] Look look(const Lanes& s) const {
        Look l;
        for (int a = 0; a < 3; ++a)
            l.digit[a] = _mm256_and_si256(_mm256_srlv_epi32(s.course.cell[a], s.shift), ints(3));
        l.high = _mm256_slli_epi32(l.digit[2], 30);
        l.half = int_columns(choose(float_columns(s.node.low), float_columns(s.node.high), float_columns(l.high)));
        const __m256i xy = _mm256_or_si256(l.digit[0], _mm256_slli_epi32(l.digit[1], 2));
        l.bit = _mm256_or_si256(xy, _mm256_slli_epi32(_mm256_and_si256(l.digit[2], ints(1)), 4));
        l.occupied = _mm256_srai_epi32(_mm256_slli_epi32(_mm256_srlv_epi32(l.half, l.bit), 31), 31);
        l.inner = _mm256_cmpeq_epi32(_mm256_srli_epi32(s.node.link, 30), _mm256_setzero_si256());
        return l;
    }

    // The nodes at the lanes' cells, where `down`.
    [[gnu::always_inline]] __m256i children(const Lanes& s, const Look& l, __m256i down) const {
        const __m256i before = _mm256_sub_epi32(_mm256_sllv_epi32(ints(1), l.bit), ints(1));
        const __m256i rank =
            popcount(_mm256_and_si256(l.half, before), _mm256_and_si256(s.node.low, _mm256_srai_epi32(l.high, 31)));
        const __m256i at = _mm256_and_si256(_mm256_add_epi32(s.node.link, rank), down);
        if (!references_) return at;
        return _mm256_mask_i32gather_epi32(_mm256_setzero_si256(), reinterpret_cast<const int*>(references_), at, down,
                                           4);
    }

    // Nodes by their number. Eight loads and a transposition, which take less time than three gathers.
    [[gnu::always_inline]] Nodes fetch(__m256i index) const {
        static_assert(sizeof(VoxelNode) == 12);
        alignas(32) uint at[lanes];
        store(at, index);
        const __m128i three = _mm_setr_epi32(-1, -1, -1, 0);
        const auto row = [&](int i) { return _mm_maskload_epi32(reinterpret_cast<const int*>(nodes_ + at[i]), three); };
        const auto pair = [&](int i) { return _mm256_inserti128_si256(_mm256_castsi128_si256(row(i)), row(i + 4), 1); };
        const __m256i a = pair(0), b = pair(1), c = pair(2), d = pair(3);
        const __m256i ab = _mm256_unpacklo_epi32(a, b), cd = _mm256_unpacklo_epi32(c, d);
        return {_mm256_unpacklo_epi64(ab, cd), _mm256_unpackhi_epi64(ab, cd),
                _mm256_unpacklo_epi64(_mm256_unpackhi_epi32(a, b), _mm256_unpackhi_epi32(c, d))};
    }

    // Down to the children, where `down`.
    [[gnu::always_inline]] void descend(Lanes& s, const Look& l, __m256i down) const {
        const __m256i index = children(s, l, down);
        s.shift = _mm256_add_epi32(s.shift, _mm256_add_epi32(down, down));
        for (int level = 0; 2 * level < top_shift_; ++level)
            s.stack[level] =
                choose(s.stack[level], index, _mm256_and_si256(down, _mm256_cmpeq_epi32(s.shift, ints(2 * level))));
        s.node = choose(s.node, fetch(index), down);
    }

    // The binary logarithm of the edge of the cube of nothing that each lane is in; only where nothing is there.
    [[gnu::always_inline]] __m256i empty_cube(const Lanes& s, const Look& l) const {
        // Children on the ray's side of the digit of each axis, by that digit, and 4 more where the ray goes up.
        const __m256i x_ahead = _mm256_setr_epi32(0x11111111, 0x33333333, 0x77777777, -1, -1, int(0xeeeeeeee),
                                                  int(0xcccccccc), int(0x88888888));
        const __m256i y_ahead = _mm256_setr_epi32(0x000f000f, 0x00ff00ff, 0x0fff0fff, -1, -1, int(0xfff0fff0),
                                                  int(0xff00ff00), int(0xf000f000));
        const __m256i z_ahead_low = _mm256_setr_epi32(0x0000ffff, -1, -1, -1, -1, int(0xffff0000), 0, 0);
        const __m256i z_ahead_high = _mm256_setr_epi32(0, 0, 0x0000ffff, -1, -1, -1, -1, int(0xffff0000));
        const auto entry = [&](int a) {
            return _mm256_or_si256(l.digit[a], _mm256_and_si256(s.course.positive[a], ints(4)));
        };
        const __m256i xy_ahead = _mm256_and_si256(_mm256_permutevar8x32_epi32(x_ahead, entry(0)),
                                                  _mm256_permutevar8x32_epi32(y_ahead, entry(1)));
        const __m256i z = entry(2);
        const __m256i low = _mm256_and_si256(s.node.low, _mm256_permutevar8x32_epi32(z_ahead_low, z));
        const __m256i high = _mm256_and_si256(s.node.high, _mm256_permutevar8x32_epi32(z_ahead_high, z));
        const __m256i none = _mm256_setzero_si256();
        const __m256i node = _mm256_cmpeq_epi32(_mm256_and_si256(xy_ahead, _mm256_or_si256(low, high)), none);
        // The 2×2×2 children around the cell.
        const __m256i block = _mm256_srlv_epi32(l.half, _mm256_and_si256(l.bit, ints(0x0a)));
        const __m256i eight = _mm256_cmpeq_epi32(_mm256_and_si256(block, ints(0x00330033)), none);
        return _mm256_sub_epi32(s.shift, _mm256_add_epi32(node, _mm256_or_si256(node, eight)));
    }

    // One step of every lane: down by up to two nodes, or out of a cube of nothing, or both.
    [[gnu::always_inline]] void step(Lanes& s) const {
        Look l = look(s);
        if (lanes_of(_mm256_and_si256(l.occupied, l.inner)) & s.live) {
            descend(s, l, _mm256_and_si256(l.occupied, l.inner));
            l = look(s);
        }
        const __m256i down = _mm256_and_si256(l.occupied, l.inner);
        const __m256i met = _mm256_andnot_si256(l.inner, l.occupied);
        const unsigned hit = lanes_of(met) & s.live;
        s.hit |= hit;
        s.live &= ~hit;

        const Course& c = s.course;
        const __m256i edge = _mm256_sllv_epi32(ints(1), empty_cube(s, l)), rest = _mm256_sub_epi32(edge, ints(1));
        __m256i lower[3], upper[3], plane[3];
        __m256 t[3];
        for (int a = 0; a < 3; ++a) {
            lower[a] = _mm256_andnot_si256(rest, c.cell[a]);
            upper[a] = _mm256_or_si256(rest, c.cell[a]);
            plane[a] = _mm256_add_epi32(lower[a], _mm256_and_si256(c.positive[a], edge));
            t[a] = _mm256_mul_ps(_mm256_sub_ps(_mm256_cvtepi32_ps(plane[a]), c.plane_origin[a]), c.inverse[a]);
        }
        const __m256 nearest = _mm256_min_ps(_mm256_min_ps(t[0], t[1]), t[2]);
        __m256 crosses[3];  // x before y before z
        crosses[0] = _mm256_cmp_ps(t[0], nearest, _CMP_EQ_OQ);
        crosses[1] = _mm256_andnot_ps(crosses[0], _mm256_cmp_ps(t[1], nearest, _CMP_EQ_OQ));
        crosses[2] = _mm256_andnot_ps(_mm256_or_ps(crosses[0], crosses[1]), all_lanes());

        __m256i next[3];
        __m256 sure = all_lanes();
        for (int a = 0; a < 3; ++a) {
            const __m256 position = _mm256_add_ps(c.origin[a], _mm256_mul_ps(nearest, c.direction[a]));
            const __m256i inside =
                _mm256_max_epi32(_mm256_min_epi32(_mm256_cvttps_epi32(position), upper[a]), lower[a]);
            const __m256 off = _mm256_sub_ps(_mm256_sub_ps(position, _mm256_cvtepi32_ps(inside)), floats(0.5f));
            sure = _mm256_and_ps(sure, _mm256_or_ps(crosses[a], _mm256_cmp_ps(magnitude(off), c.sure, _CMP_LE_OQ)));
            const __m256i beyond = _mm256_add_epi32(plane[a], _mm256_sub_epi32(ints(-1), c.positive[a]));
            next[a] = choose(inside, beyond, int_columns(crosses[a]));
        }
        const unsigned going = s.live & ~lanes_of(down);
        if (const unsigned doubtful = going & ~lanes_of(sure)) [[unlikely]]
            decide(s, doubtful, nearest, crosses, lower, upper, next);

        __m256i changed = _mm256_setzero_si256(), outside = _mm256_setzero_si256();
        for (int a = 0; a < 3; ++a) {
            changed = _mm256_or_si256(changed, _mm256_xor_si256(next[a], c.cell[a]));
            // The sign of either tells that a coordinate left the set.
            const __m256i above = _mm256_sub_epi32(ints(grid_.size[a] - 1), next[a]);
            outside = _mm256_or_si256(outside, _mm256_or_si256(next[a], above));
        }
        const __m256 too_far = _mm256_cmp_ps(nearest, c.limit, _CMP_GE_OQ);
        s.live &= ~(going & (lanes_of(outside) | lanes_of(too_far)));

        for (int a = 0; a < 3; ++a) s.course.cell[a] = choose(next[a], c.cell[a], l.occupied);
        s.course.t = choose(nearest, c.t, float_columns(l.occupied));
        const __m256i x = int_columns(crosses[0]), y = int_columns(crosses[1]);
        const __m256i axis = _mm256_add_epi32(_mm256_add_epi32(ints(2), y), _mm256_add_epi32(x, x));
        s.axis = choose(axis, s.axis, l.occupied);
        ascend(s, l, changed, down, met);
    }

    // The cells that rounding leaves in doubt.
    void decide(const Lanes& s, unsigned which, __m256 nearest, const __m256 crosses[3], const __m256i lower[3],
                const __m256i upper[3], __m256i next[3]) const {
        alignas(32) int cells[3][lanes], low[3][lanes], high[3][lanes], index[lanes];
        alignas(32) float t[lanes];
        for (int a = 0; a < 3; ++a) {
            store(cells[a], next[a]);
            store(low[a], lower[a]);
            store(high[a], upper[a]);
        }
        store(index, s.course.ray);
        _mm256_store_ps(t, nearest);
        const unsigned x = lanes_of(crosses[0]), y = lanes_of(crosses[1]);
        for (; which; which &= which - 1) {
            const int i = std::countr_zero(which);
            const int axis = x >> i & 1 ? 0 : y >> i & 1 ? 1 : 2;
            const Ray& r = rays_[std::size_t(index[i])];
            for (int a = 0; a < 3; ++a)
                if (a != axis)
                    cells[a][i] = voxel_cell(r.origin[a], r.direction[a], safe_inverse(r.direction[a]), t[i], a < axis,
                                             low[a][i], high[a][i]);
        }
        for (int a = 0; a < 3; ++a) next[a] = load(cells[a]);
    }

    // To the node that holds the next cell: the lowest that held the last one too, or its child, where `down`. Lanes
    // that have met something keep theirs.
    [[gnu::always_inline]] void ascend(Lanes& s, const Look& l, __m256i changed, __m256i down, __m256i met) const {
        // The highest bit that changed is the exponent of the number.
        const __m256i exponent = _mm256_srli_epi32(int_columns(_mm256_cvtepi32_ps(changed)), 23);
        const __m256i ancestor = _mm256_and_si256(_mm256_sub_epi32(exponent, ints(127)), ints(-2));
        s.shift = choose(ancestor, _mm256_add_epi32(s.shift, _mm256_add_epi32(down, down)), l.occupied);
        __m256i index = _mm256_setzero_si256();
        __m256i at_level[VOXEL_MAX_LEVELS];
        for (int level = 0; 2 * level < top_shift_; ++level) {
            at_level[level] = _mm256_cmpeq_epi32(s.shift, ints(2 * level));
            index = choose(index, s.stack[level], at_level[level]);
        }
        index = choose(index, children(s, l, down), down);
        for (int level = 0; 2 * level < top_shift_; ++level)
            s.stack[level] = choose(s.stack[level], index, at_level[level]);
        const __m256i at_top = _mm256_cmpgt_epi32(s.shift, ints(top_shift_ - 1));
        s.node = choose(choose(fetch(index), root_, at_top), s.node, met);
    }

    const SceneView& scene_;
    uint grid_index_, slot_first_, instance_;
    const VoxelGrid& grid_;
    std::span<const Ray> rays_;
    Hit* hits_;
    const VoxelNode* nodes_;
    const uint* references_ = nullptr;
    Nodes root_;
    int top_shift_;  // two bits of a coordinate for each level

    Queue queue_;
    std::size_t next_ray_ = 0;
};

}  // namespace

void stream_closest(const SceneView& scene, uint grid, uint slot_first, uint instance, std::span<const Ray> rays,
                    Hit* hits) {
    if (!rays.empty()) Stream(scene, grid, slot_first, instance, rays, hits).run();
}

}  // namespace spinel

SPINEL_AVX2_END
#endif
