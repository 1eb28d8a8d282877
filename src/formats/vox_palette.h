#pragma once
// How materials and media become entries of MagicaVoxel's palette, the inverse of vox_material.h: what an entry says,
// what of a material it cannot say, and many entries as few.

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/result.h"
#include "formats/vox_file.h"
#include "spinel/scene.h"

namespace spinel::vox {

// One palette entry: its sRGB colour, and what its material chunk says.
struct Entry {
    std::array<std::uint8_t, 4> color = {0, 0, 0, 255};
    Dictionary properties;
    bool operator==(const Entry&) const = default;
};

// `scale`: units a voxel, which is one in the file; what is inside stays as dense.
Entry entry_of(const kernels::Material& material, const Medium* inside, float scale);
Entry entry_of(const Medium& cloud, float scale);

// What is read back of the entry is not what the material says: names of parameters, "textures" and, where its kind
// changes, "principled → diffuse".
std::vector<std::string> losses(const kernels::Material& material, const Medium* inside, float scale);

// At most `most` entries for all, each used by so many voxels: colours of entries that are alike in all else are drawn
// together by how they look (image/palette.h). An error if more than `most` differ in something else than colour.
struct FewEntries {
    std::vector<Entry> entries;
    std::vector<std::size_t> index;  // into them, of each that was given
};
Result<FewEntries> few_entries(std::span<const Entry> entries, std::span<const std::uint64_t> voxels, std::size_t most);

}  // namespace spinel::vox
