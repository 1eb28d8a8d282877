#pragma once
// The devices by name. A new device: its folder beside this file, and one row in devices.cpp.

#include <memory>
#include <string>
#include <vector>

#include "core/result.h"
#include "render/device.h"

namespace spinel {

struct DeviceInfo {
    const char* name;
    const char* doc;
    std::unique_ptr<Device> (*make)();
};
const std::vector<DeviceInfo>& device_infos();

// By name, or an error that lists what there is.
Result<const DeviceInfo*> find_device(const std::string& name);
Result<std::unique_ptr<Device>> make_device(const std::string& name);

}  // namespace spinel
