#pragma once
// Textures of a model that Assimp has read: embedded in it, or files beside it.

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "core/result.h"
#include "spinel/scene.h"

struct aiMaterial;
struct aiScene;

namespace spinel {

// color    as stored, sRGB
// data     as stored, linear: normals, roughness
// alpha    channel a as opacity; a picture without one has none
// mask     the same, but all or nothing at a threshold
// coverage alpha where there is one, else the grey value (map_d of MTL)
enum class TextureRole { color, data, alpha, mask, coverage };

// Appends to Scene::textures; every picture is read once, every use with the same settings is one texture.
class MeshTextures {
  public:
    MeshTextures(const std::filesystem::path& model, const aiScene& source, Scene& scene);

    // Index of the texture that the material uses for `type` (an aiTextureType), kernels::NONE if it uses
    // none. `mask` counts a texel as opaque from `cutoff` on. Fails when the picture is missing or
    // unreadable.
    Result<std::uint32_t> add(const aiMaterial& material, int type, TextureRole role, float cutoff = 0);

    // The one uv set that the textures of a material added so far use; empty: none does.
    // begin_material() forgets it. A material whose textures use several is refused by add().
    void begin_material() { uv_set_.reset(); }
    std::optional<unsigned> uv_set() const { return uv_set_; }

  private:
    Result<std::shared_ptr<const PixelBuffer>> pixels(const std::string& name, bool srgb);

    const std::filesystem::path& model_;
    const aiScene& source_;
    Scene& scene_;
    std::map<std::pair<std::string, bool>, std::shared_ptr<const PixelBuffer>> pixels_;  // by name and use as colour
    std::map<std::string, std::uint32_t> textures_;                                      // by name and all settings
    std::optional<unsigned> uv_set_;
};

}  // namespace spinel
