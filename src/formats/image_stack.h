#pragma once
// A volume as a row of pictures: a folder, of whose pictures those are taken that have the extension of the first, or a
// name with a number's place in it such as slices/ct_%04d.png, from the first number below 1000 that there is a file
// for. Slices stand along z in the order of the numbers in their names, the picture's top along +y. Integers are 0 … 1.
// Of colours the mean is taken.

#include <filesystem>

#include "core/result.h"
#include "spinel/scene.h"

namespace spinel {

bool is_image_stack(const std::filesystem::path& path);
Result<Scene> load_image_stack(const std::filesystem::path& path);

}  // namespace spinel
