#pragma once
// The CPU: tiles over oneTBB, one path after the other through the kernels compiled as C++.

#include <memory>

#include "render/device.h"

namespace spinel {

std::unique_ptr<Device> make_cpu_device();

}  // namespace spinel
