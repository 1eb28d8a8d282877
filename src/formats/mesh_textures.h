#pragma once
// Textures of a model that Assimp has read: embedded in it, or files beside it.

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/result.h"
#include "formats/gltf_extras.h"
#include "spinel/scene.h"

struct aiMaterial;
struct aiScene;

namespace spinel {

// color    as stored, sRGB
// data     as stored, linear: normals, roughness
// alpha    channel a as opacity; a picture without one has none
// mask     the same, but all or nothing at a threshold
// coverage alpha where there is one, else the grey value (map_d of MTL)
// relief   a map of normals from heights (map_bump of MTL); pictures of colours are taken for such a map
enum class TextureRole { color, data, alpha, mask, coverage, relief };

// Appends to Scene::textures; every picture is read once, every use with the same settings is one texture.
class MeshTextures {
  public:
    MeshTextures(const std::filesystem::path& model, const aiScene& source, Scene& scene);

    // Index of the texture that the material uses for `type` (an aiTextureType and a number among those of the
    // type), kernels::NONE if it uses none. `mask` counts a texel as opaque from `amount` on; in a `relief` black and
    // white are so many texels apart. `place` replaces what Assimp tells of texture coordinates. Fails when the picture
    // is unreadable, or missing where that is not allowed.
    struct Use {
        int type = 0;
        unsigned number = 0;
        TextureRole role = TextureRole::color;
        float amount = 0;
        const GltfTexturePlace* place = nullptr;
    };
    Result<std::uint32_t> add(const aiMaterial& material, const Use& use);

    // The file's uv sets, at most two, that the textures of a material added so far use, the first one first:
    // ImageTexture::uv_set is the place among them. begin_material() forgets them.
    void begin_material() { uv_sets_.clear(); }
    const std::vector<unsigned>& uv_sets() const { return uv_sets_; }

    // From now on a picture that is not there is as good as none. Names of those so far, each once.
    void allow_missing() { missing_allowed_ = true; }
    const std::vector<std::string>& missing() const { return missing_; }

  private:
    // Null: it is not there, which is allowed.
    Result<std::shared_ptr<const PixelBuffer>> pixels(const std::string& name, bool srgb);

    const std::filesystem::path& model_;
    const aiScene& source_;
    Scene& scene_;
    std::map<std::pair<std::string, bool>, std::shared_ptr<const PixelBuffer>> pixels_;  // by name and use as colour
    std::map<std::string, std::uint32_t> textures_;                                      // by name and all settings
    std::vector<unsigned> uv_sets_;
    bool missing_allowed_ = false;
    std::vector<std::string> missing_;
};

}  // namespace spinel
