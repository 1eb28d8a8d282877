#pragma once
// What the block files of Minecraft share: palettes of block states, and arrays of palette indices packed into 64-bit
// words.

#include <string>
#include <vector>

#include "core/result.h"
#include "formats/block_scene.h"
#include "formats/nbt.h"

namespace spinel {

// "minecraft:oak_log[axis=y]" of a compound of Name and Properties.
std::string state_text(const nbt::Tag& entry);

// The states of a list of such compounds.
Result<std::vector<std::uint32_t>> read_palette(const nbt::Tag& list, BlockScene& scene);

// How many bits tell apart `count` palette entries, at least `least`.
int bits_for(std::size_t count, int least);

// Indices of `bits` bits, the lowest first, in an int64_array. Where they span words none of its bits is unused;
// otherwise a word holds as many whole indices as fit.
class PackedIndices {
  public:
    PackedIndices(const nbt::Tag& words, int bits, bool spanning);
    // Index i; the caller has checked that there are enough words.
    std::size_t operator[](std::size_t i) const;
    // Words that `count` indices take.
    static std::size_t words_for(std::size_t count, int bits, bool spanning);

  private:
    std::vector<std::uint64_t> words_;
    int bits_;
    bool spanning_;
};

}  // namespace spinel
