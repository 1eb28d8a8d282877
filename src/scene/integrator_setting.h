#pragma once
// Settings of the integrator as the command line gives them: a key of the scene file's "integrator" and its value.

#include <string>

#include "core/result.h"
#include "spinel/scene.h"

namespace spinel {

// "ao_radius=2". Errors are those of the scene file.
Result<void> set_integrator(IntegratorSettings& settings, const std::string& assignment);

}  // namespace spinel
