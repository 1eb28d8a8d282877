#include "formats/vox_palette.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>

#include "formats/vox_material.h"
#include "image/palette.h"
#include "image/tone_map.h"
#include "kernels/fresnel.h"
#include "kernels/materials.h"
#include "scene/material_registry.h"

namespace spinel::vox {
namespace {

std::string decimal(float value) {
    char digits[32];
    const auto end = std::to_chars(digits, digits + sizeof digits, value);
    return std::string(digits, end.ptr);
}

void set_color(Entry& entry, vec3 linear) {
    for (int c = 0; c < 3; ++c)
        entry.color[std::size_t(c)] =
            std::uint8_t(std::lround(255.0f * std::clamp(srgb_encoded(std::max(linear[c], 0.0f)), 0.0f, 1.0f)));
}

// The inverse of vox_material.cpp's inner_medium().
void set_medium(Entry& entry, const Medium& medium, float scale) {
    const vec3 extinction = medium.scattering + medium.absorption;
    const float density = std::max({extinction.x, extinction.y, extinction.z, 1e-6f});
    Dictionary& said = entry.properties;
    said["_d"] = decimal(density * scale);
    said["_g"] = decimal(medium.g);
    if (medium.emission != vec3(0)) {
        said["_media"] = "2", said["_media_type"] = "_emit";
        set_color(entry, medium.emission / density);
    } else if (medium.scattering == vec3(0)) {
        said["_media"] = "0", said["_media_type"] = "_absorb";
        set_color(entry, 1.0f - medium.absorption / density);
    } else {
        said["_media"] = "1", said["_media_type"] = "_scatter";
        set_color(entry, medium.scattering / density);
    }
}

// Reflectance at normal incidence, whichever way it is given.
vec3 metal_color(const kernels::Material& m) {
    const bool is_exact = !kernels::is_black(m.eta) || !kernels::is_black(m.k);
    return is_exact ? kernels::fresnel_conductor(1.0f, m.eta, m.k) : m.color;
}

// Relative for large values; half a step of an 8-bit colour, and rounding, are no loss.
bool alike(float a, float b) { return std::abs(a - b) <= 0.012f + 0.03f * std::abs(b); }
bool alike(vec3 a, vec3 b) { return alike(a.x, b.x) && alike(a.y, b.y) && alike(a.z, b.z); }
bool alike(int a, int b) { return a == b; }
bool alike(kernels::uint a, kernels::uint b) { return a == b; }

bool has_textures(const kernels::Material& m) {
    for (const kernels::uint texture : {m.color_texture, m.roughness_texture, m.metallic_texture, m.emission_texture,
                                        m.normal_texture, m.opacity_texture})
        if (texture != kernels::NONE) return true;
    return false;
}

// How many entries each group gets: one at least, of the rest its share by what it has.
std::vector<std::size_t> shares(const std::vector<std::vector<std::size_t>>& groups, std::size_t most) {
    std::vector<std::size_t> share(groups.size(), 1);
    std::size_t wanted = 0, left = most - groups.size();
    for (const auto& group : groups) wanted += group.size() - 1;
    const std::size_t rest = std::min(left, wanted);
    for (std::size_t i = 0; i < groups.size(); ++i) {
        const std::size_t more = wanted > 0 ? rest * (groups[i].size() - 1) / wanted : 0;
        share[i] += more;
        left -= more;
    }
    for (std::size_t i = 0; i < groups.size(); ++i)  // what was rounded down
        for (; left > 0 && share[i] < groups[i].size(); --left) ++share[i];
    return share;
}

std::uint32_t packed(const Entry& entry) {
    return std::uint32_t(entry.color[0]) | std::uint32_t(entry.color[1]) << 8 | std::uint32_t(entry.color[2]) << 16;
}

// The entries of one group as `most`, appended to `few`.
void draw_together(FewEntries& few, std::span<const Entry> entries, std::span<const std::uint64_t> voxels,
                   const std::vector<std::size_t>& group, std::size_t most) {
    // As often as a thousand times by how many voxels have it.
    std::uint64_t largest = 1;
    for (const std::size_t i : group) largest = std::max(largest, voxels[i]);
    std::vector<std::uint32_t> colors;
    std::vector<std::size_t> first;
    for (const std::size_t i : group) {
        first.push_back(colors.size());
        const double share = double(voxels[i]) / double(largest);
        colors.insert(colors.end(), 1 + std::size_t(999 * share), packed(entries[i]));
    }
    const ColorPalette palette = quantise_colors(colors, int(most));
    const std::size_t begin = few.entries.size();
    for (const std::uint32_t color : palette.colors) {
        Entry entry = entries[group.front()];
        for (int c = 0; c < 3; ++c) entry.color[std::size_t(c)] = std::uint8_t(color >> (8 * c));
        few.entries.push_back(std::move(entry));
    }
    for (std::size_t i = 0; i < group.size(); ++i) few.index[group[i]] = begin + palette.index[first[i]];
}

}  // namespace

Entry entry_of(const Medium& cloud, float scale) {
    Entry entry;
    entry.properties["_type"] = "_media";
    set_medium(entry, cloud, scale);
    return entry;
}

Entry entry_of(const kernels::Material& m, const Medium* inside, float scale) {
    Entry entry;
    Dictionary& said = entry.properties;
    set_color(entry, m.kind == kernels::MATERIAL_METAL ? metal_color(m) : m.color);
    if (const float most = std::max({m.emission.x, m.emission.y, m.emission.z}); most > 0.0f) {
        const float flux = std::clamp(std::ceil(std::log2(most) / 2.0f), 0.0f, 4.0f);
        set_color(entry, m.emission / most);
        said["_type"] = "_emit";
        said["_emit"] = decimal(std::min(most / std::pow(4.0f, flux), 1.0f));
        said["_flux"] = decimal(flux);
        return entry;
    }
    said["_rough"] = decimal(m.roughness);
    switch (m.kind) {
        case kernels::MATERIAL_METAL:
            said["_type"] = "_metal";
            said["_metal"] = "1";
            break;
        case kernels::MATERIAL_PRINCIPLED:
            said["_type"] = "_metal";
            said["_metal"] = decimal(m.metallic);
            break;
        case kernels::MATERIAL_PLASTIC:
            said["_type"] = "_metal";
            said["_plastic"] = "1";
            break;
        case kernels::MATERIAL_DIELECTRIC:
            said["_type"] = "_glass";
            said["_trans"] = "0.5";  // by which the colour is that of light after 4 voxels
            set_color(entry, glm::exp(-4.0f * scale * m.absorption));
            if (inside) set_medium(entry, *inside, scale);
            break;
        default: said["_type"] = "_diffuse"; break;
    }
    if (m.kind == kernels::MATERIAL_DIELECTRIC || m.kind == kernels::MATERIAL_PLASTIC) {
        said["_ri"] = decimal(m.ior);
        said["_ior"] = decimal(m.ior - 1.0f);
    }
    return entry;
}

std::vector<std::string> losses(const kernels::Material& material, const Medium* inside, float scale) {
    const Entry entry = entry_of(material, inside, scale);
    kernels::Material meant = material, read = appearance(entry.color, entry.properties).material;
    std::vector<std::string> lost;
    if (has_textures(material)) lost.push_back("textures");
    if (read.kind != meant.kind)
        lost.push_back(std::string(find_material_info(meant.kind)->name) + " → " +
                       std::string(find_material_info(read.kind)->name));
    if (meant.kind == kernels::MATERIAL_METAL) {  // a complex index is kept as the colour that it gives
        meant.color = metal_color(meant);
        meant.eta = meant.k = vec3(0);
    }
    // Over four voxels, and as light that is left: what is nearly black stays so.
    meant.absorption = inside ? vec3(0) : glm::exp(-4.0f * scale * meant.absorption);
    read.absorption = inside ? vec3(0) : glm::exp(-4.0f * read.absorption);
    const auto compare = [&](std::span<const MaterialParameter> parameters) {
        for (const MaterialParameter& parameter : parameters)
            std::visit(
                [&](auto member) {
                    if (!alike(read.*member, meant.*member)) lost.emplace_back(parameter.name);
                },
                parameter.member);
    };
    compare(find_material_info(meant.kind)->parameters);
    compare(common_material_parameters());
    return lost;
}

Result<FewEntries> few_entries(std::span<const Entry> entries, std::span<const std::uint64_t> voxels,
                               std::size_t most) {
    FewEntries few;
    few.index.resize(entries.size());
    if (entries.size() <= most) {
        few.entries.assign(entries.begin(), entries.end());
        for (std::size_t i = 0; i < entries.size(); ++i) few.index[i] = i;
        return few;
    }
    std::map<Dictionary, std::vector<std::size_t>> by_properties;
    for (std::size_t i = 0; i < entries.size(); ++i) by_properties[entries[i].properties].push_back(i);
    if (by_properties.size() > most)
        return Error{"its materials are of " + std::to_string(by_properties.size()) +
                     " sorts that differ in more than colour; a palette has room for " + std::to_string(most)};
    std::vector<std::vector<std::size_t>> groups;
    for (auto& [properties, group] : by_properties) groups.push_back(std::move(group));
    const std::vector<std::size_t> share = shares(groups, most);
    for (std::size_t i = 0; i < groups.size(); ++i) draw_together(few, entries, voxels, groups[i], share[i]);
    return few;
}

}  // namespace spinel::vox
