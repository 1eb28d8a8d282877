// A city on a grid of streets. Every cell is told from its coordinates: the block that it lies in, the lot of the
// block, the building on the lot, the face of the building, the window in the face.

#include <algorithm>
#include <cmath>

#include "scene/worlds/worlds.h"

namespace spinel {
namespace {

enum Palette : std::uint16_t {
    AIR,
    ASPHALT,
    LANE,
    PAVEMENT,
    LAWN,
    PATH,
    TRUNK,
    LEAVES,
    LEAVES_LIGHT,
    POND,
    CONCRETE,
    BRICK,
    SANDSTONE,
    PLASTER,
    STEEL,
    SLATE,  // walls, in the order of `walls`
    PANE,
    PANE_DARK,
    WARM,
    COOL,
    AMBER,
    SHOP,
    ROOF,
    PLANT,
    LAMP_POST,
    LAMP,
    BEACON,
    CAR_RED,
    CAR_WHITE,
    CAR_BLUE,
    CAR_BLACK,
    HEADLIGHT,
    TAILLIGHT,
};
const WorldMaterial palette[] = {
    {"asphalt", 0x4a4b4f},
    {"lane", 0xd8d4c4},
    {"pavement", 0x9a978f},
    {"lawn", 0x6d9248},
    {"path", 0xc2ad86},
    {"trunk", 0x5a4230},
    {"leaves", 0x4c7636},
    {"light leaves", 0x6f963f},
    {"pond", 0x3f8ea0},
    {"concrete", 0xa9a59d},
    {"brick", 0x9a5a44},
    {"sandstone", 0xc9ab7c},
    {"plaster", 0xd9d2c4},
    {"steel", 0x6f7d8c},
    {"slate", 0x54585f},
    {"pane", 0x39546a},
    {"dark pane", 0x26323d},
    {"warm window", 0xffc978, 3},
    {"cool window", 0xcfe4ff, 2.5f},
    {"amber window", 0xff9d4a, 2.5f},
    {"shop window", 0xffe2ae, 4},
    {"roof", 0x77736c},
    {"roof plant", 0x8d9092},
    {"lamp post", 0x3a3c40},
    {"lamp", 0xffd9a0, 30},
    {"beacon", 0xff2a1c, 25},
    {"red car", 0xb02a22},
    {"white car", 0xe6e6e2},
    {"blue car", 0x2b4f8e},
    {"black car", 0x1c1d20},
    {"headlight", 0xfff4d8, 12},
    {"taillight", 0xff1e12, 6},
};

constexpr int pitch = 56;    // from street to street
constexpr int street = 14;   // with its pavements
constexpr int pavement = 3;  // on either side
constexpr int storey = 4;

struct Building {
    ivec2 lower, upper;  // of the lot, in cells of the block; empty: no building
    int height = 0;
    std::uint16_t wall = 0;
    std::uint32_t hash = 0;
    int style = 0;  // of the windows: 0 holes, 1 bands, 2 columns
    int steps = 0;  // how often it narrows on its way up
};

class City {
  public:
    City(ivec3 size, std::uint32_t seed) : size_(size), seed_(seed) {}

    std::uint16_t at(ivec3 c) const {
        if (c.y == 0) return ground(c);
        const ivec2 in(c.x % pitch, c.z % pitch), block(c.x / pitch, c.z / pitch);
        if (in.x < street || in.y < street) return on_street(c, in, block);
        if (is_park(block)) return in_park(c, in - street, block);
        const Building b = building(block, in - street);
        return b.height == 0 ? 0 : in_building(c, in - street, b);
    }

    std::optional<std::uint16_t> box(ivec3 lower, ivec3) const {
        return lower.y > tallest() + 14 ? std::optional<std::uint16_t>(std::uint16_t(0)) : std::nullopt;
    }

  private:
    static constexpr int block_edge = pitch - street;

    int tallest() const { return std::max(8, size_.y - 16); }
    bool is_park(ivec2 block) const { return world_hash(block.x, 3, block.y, seed_) % 9 == 0; }

    std::uint16_t ground(ivec3 c) const {
        const ivec2 in(c.x % pitch, c.z % pitch);
        if (in.x >= street && in.y >= street) {
            const ivec2 block(c.x / pitch, c.z / pitch);
            return is_park(block) ? park_ground(in - street, block) : std::uint16_t(PAVEMENT);
        }
        const bool along_x = in.y < street, along_z = in.x < street;
        const auto walk = [](int across) { return across < pavement || across >= street - pavement; };
        if (along_x && along_z) {
            if (walk(in.x) && walk(in.y)) return PAVEMENT;
            return ASPHALT;
        }
        const int across = along_x ? in.y : in.x, along = along_x ? in.x : in.y;
        if (walk(across)) return PAVEMENT;
        if ((along == street + 1 || along == street + 2 || along == pitch - 3 || along == pitch - 2) && across % 2 == 1)
            return LANE;  // where people cross
        const bool middle = across == street / 2 || across == street / 2 - 1;
        return middle && along % 6 < 3 && along > street + 4 && along < pitch - 5 && across == street / 2 ? LANE
                                                                                                          : ASPHALT;
    }

    std::uint16_t on_street(ivec3 c, ivec2 in, ivec2 block) const {
        const bool along_x = in.y < street, along_z = in.x < street;
        if (along_x && along_z) return 0;
        const int across = along_x ? in.y : in.x, along = along_x ? in.x : in.y;
        // Lamps stand at the kerb and reach over it.
        const int at = along % 14;
        if (across == pavement - 1 || across == street - pavement) {
            if (at == 7 && c.y <= 8) return LAMP_POST;
        }
        if (at == 7 && c.y == 9) {
            if (across == pavement - 1 || across == street - pavement) return LAMP_POST;
            if (across == pavement || across == street - pavement - 1) return LAMP;
        }
        if (c.y > 2) return 0;
        // Cars: 3 wide, 6 long, on either side of the middle.
        const bool left = across >= pavement && across < pavement + 3;
        const bool right = across >= street - pavement - 3 && across < street - pavement;
        if (!left && !right) return 0;
        const int slot = along / 9, within = along % 9;
        if (along < street + 4 || along >= pitch - 6 || within >= 6) return 0;
        const std::uint32_t h = world_hash(block.x * 16 + slot, left + 2 * along_x, block.y, seed_ + 5);
        if (h % 100 >= 38) return 0;
        static constexpr std::uint16_t cars[] = {CAR_RED, CAR_WHITE, CAR_WHITE, CAR_BLUE, CAR_BLACK, CAR_BLACK};
        const std::uint16_t body = cars[h / 100 % 6];
        if (c.y == 2) {
            if (within == 1 || within == 4) return PANE_DARK;
            return within == 2 || within == 3 ? body : std::uint16_t(AIR);
        }
        const bool corner = across == pavement || across == pavement + 2 || across == street - pavement - 3 ||
                            across == street - pavement - 1;
        const bool front = left ? within == 0 : within == 5, back = left ? within == 5 : within == 0;
        if (corner && front) return HEADLIGHT;
        if (corner && back) return TAILLIGHT;
        return body;
    }

    std::uint16_t park_ground(ivec2 p, ivec2 block) const {
        const ivec2 d = p - block_edge / 2;
        const ivec2 e = d - ivec2(int(world_hash(block.x, 8, block.y, seed_) % 9) - 4, 3);
        if (e.x * e.x + e.y * e.y < 60) return POND;
        if (e.x * e.x + e.y * e.y < 84) return PATH;
        if (std::abs(d.x) < 2 || std::abs(d.y) < 2) return PATH;
        return LAWN;
    }

    std::uint16_t in_park(ivec3 c, ivec2 p, ivec2 block) const {
        if (c.y > 13) return 0;
        // Trees in cells of 7, which their crowns do not leave.
        const ivec2 cell = p / 7;
        const std::uint32_t h = world_hash(block.x * 8 + cell.x, 4, block.y * 8 + cell.y, seed_);
        const ivec2 foot = cell * 7 + 3;
        if (h % 10 < 3 || park_ground(foot, block) != LAWN) return 0;
        const ivec2 d = p - foot;
        const int trunk = 4 + int(h >> 8 & 3);
        if (d == ivec2(0) && c.y <= trunk) return TRUNK;
        const int up = c.y - trunk - 2;
        if (d.x * d.x + d.y * d.y + up * up > 10) return 0;
        if (world_hash(c.x, c.y, c.z, seed_) % 100 > 88) return 0;
        return h >> 12 & 1 ? LEAVES : LEAVES_LIGHT;
    }

    // The building whose lot the place lies in. A block is one lot, two or four.
    Building building(ivec2 block, ivec2 p) const {
        Building b;
        const std::uint32_t h = world_hash(block.x, 1, block.y, seed_);
        const ivec2 halves((h % 5) != 0, (h / 5 % 4) != 0);
        const ivec2 lot(halves.x && p.x >= block_edge / 2, halves.y && p.y >= block_edge / 2);
        b.lower = lot * (block_edge / 2) + 2;
        b.upper = ivec2(halves.x ? (lot.x + 1) * (block_edge / 2) : block_edge,
                        halves.y ? (lot.y + 1) * (block_edge / 2) : block_edge) -
                  2;
        b.hash = world_hash(block.x * 2 + lot.x, 2, block.y * 2 + lot.y, seed_ + 1);
        // Tall in the middle, low towards the outskirts.
        const float u = (float(block.x) + 0.5f) * pitch / float(size_.x) - 0.5f;
        const float v = (float(block.y) + 0.5f) * pitch / float(size_.z) - 0.5f;
        const float centre = std::exp(-9.0f * (u * u + v * v));
        const float chance = float(b.hash & 0xffff) / 65535.0f;
        const float tall = 0.06f + 0.9f * centre * chance * chance + 0.16f * chance;
        const int storeys = std::max(3, int(tall * float(tallest()) / storey));
        b.height = std::min(storeys * storey + 2, tallest());
        static constexpr std::uint16_t low[] = {BRICK, SANDSTONE, PLASTER, BRICK, CONCRETE, PLASTER};
        static constexpr std::uint16_t high[] = {CONCRETE, STEEL, SLATE, STEEL, SANDSTONE, CONCRETE};
        const bool tower = b.height > 60;
        b.wall = (tower ? high : low)[b.hash >> 16 & 0xff ? (b.hash >> 16) % 6 : 0];
        b.style = tower ? int(b.hash >> 20) % 3 : int(b.hash >> 20 & 1);
        b.steps = b.height > 80 ? 2 : b.height > 44 ? int(b.hash >> 24 & 1) : 0;
        return b;
    }

    std::uint16_t in_building(ivec3 c, ivec2 p, const Building& b) const {
        const int y = c.y;
        // Narrower from half and from four fifths of the height on.
        int inset = 0;
        if (b.steps >= 1 && y > b.height * 11 / 20) inset = 3;
        if (b.steps >= 2 && y > b.height * 4 / 5) inset = 6;
        const ivec2 lower = b.lower + inset, upper = b.upper - inset;
        const bool within = p.x >= lower.x && p.y >= lower.y && p.x < upper.x && p.y < upper.y;
        if (!within || y > b.height) return y > b.height ? on_roof(p, y - b.height, lower, upper, b) : 0;
        const int from_x = std::min(p.x - lower.x, upper.x - 1 - p.x),
                  from_y = std::min(p.y - lower.y, upper.y - 1 - p.y);
        if (from_x > 0 && from_y > 0) {
            // The top is sunk by one, so that a parapet remains.
            if (y == b.height) return AIR;
            return y == b.height - 1 ? std::uint16_t(ROOF) : b.wall;
        }
        if (from_x == 0 && from_y == 0) return b.wall;
        const int along = from_x == 0 ? p.y - lower.y : p.x - lower.x;
        const int side = from_x == 0 ? (p.x == lower.x) : 2 + (p.y == lower.y);
        return facade(along, y - 1, (from_x == 0 ? upper.y - lower.y : upper.x - lower.x), side, b);
    }

    std::uint16_t facade(int along, int y, int width, int side, const Building& b) const {
        const int floor = y / storey, over = y % storey;
        if (y + 3 >= b.height) return b.wall;
        if (floor == 0) {  // shops
            if (over == 0 || over == 3 || along == 0 || along == width - 1) return b.wall;
            const std::uint32_t h = world_hash(along / 5, side, 0, b.hash);
            if (along % 5 == 0) return b.wall;
            return h % 100 < 55 ? SHOP : PANE_DARK;
        }
        bool glass = false;
        int window = 0;
        switch (b.style) {
            case 0:
                glass = (over == 1 || over == 2) && along % 3 != 0 && along < width - 1;
                window = along / 3;
                break;
            case 1:
                glass = over != 0 && along > 0 && along < width - 1;
                window = along / 4;
                break;
            default:
                glass = along % 4 != 0 && over != 3;
                window = along / 4;
                break;
        }
        if (!glass) return b.wall;
        // Light where people are: some floors wholly, some rooms.
        const std::uint32_t room = world_hash(window, floor, side, b.hash), whole = world_hash(floor, 7, 0, b.hash);
        const bool lit = room % 100 < 9 || (whole % 100 < 4 && room % 100 < 70);
        if (!lit) return room >> 8 & 3 ? PANE : PANE_DARK;
        const std::uint32_t tint = (whole >> 8) % 10;
        return tint < 5 ? WARM : tint < 8 ? COOL : AMBER;
    }

    std::uint16_t on_roof(ivec2 p, int over, ivec2 lower, ivec2 upper, const Building& b) const {
        const ivec2 middle = (lower + upper) / 2;
        if (b.height > 90 && p == middle && over <= 12) return over == 12 ? BEACON : LAMP_POST;
        if (over > 3 || glm::any(glm::lessThan(p, lower + 2)) || glm::any(glm::greaterThanEqual(p, upper - 2)))
            return 0;
        const ivec2 cell = (p - lower) / 4;
        const std::uint32_t h = world_hash(cell.x, 6, cell.y, b.hash);
        const ivec2 in = (p - lower) % 4;
        return h % 100 < 30 && over <= 1 + int(h >> 8 & 1) && in.x < 3 && in.y < 3 ? PLANT : 0;
    }

    ivec3 size_;
    std::uint32_t seed_;
};

}  // namespace

Result<Scene> make_city(ivec3 size, std::uint32_t seed) {
    if (size.y < 32) return Error{"a city needs a height of at least 32"};
    const City city(size, seed);
    Result<VoxelTreePointer> tree =
        build_voxel_tree(size, {[&](ivec3 c) { return city.at(c); }, [&](ivec3 l, ivec3 u) { return city.box(l, u); }});
    if (!tree) return tree.error();
    return world_scene("city", *tree, palette);
}

}  // namespace spinel
