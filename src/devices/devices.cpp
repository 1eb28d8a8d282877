#include "devices/devices.h"

#include <fmt/format.h>

#include "devices/cpu/cpu_device.h"

namespace spinel {

const std::vector<DeviceInfo>& device_infos() {
    static const std::vector<DeviceInfo> rows = {
        {"cpu", "this machine's cores, through oneTBB", make_cpu_device},
    };
    return rows;
}

Result<const DeviceInfo*> find_device(const std::string& name) {
    std::string available;
    for (const DeviceInfo& row : device_infos()) {
        if (name == row.name) return &row;
        available += (available.empty() ? "" : ", ") + std::string(row.name);
    }
    return Error{fmt::format("unknown device '{}'; available: {}", name, available)};
}

Result<std::unique_ptr<Device>> make_device(const std::string& name) {
    const Result<const DeviceInfo*> info = find_device(name);
    if (!info) return info.error();
    return (*info)->make();
}

}  // namespace spinel
