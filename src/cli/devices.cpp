#include <fmt/core.h>
#include "cli/command.h"
#include "cli/results.h"
#include "core/json.h"
#include "vulkan/context.h"

namespace etendue::cli {
namespace {

Ending list(bool json) {
  const auto devices = vulkan::list_devices(gpu_context_options());
  auto out = Json::array();
  for (const vulkan::DeviceInfo& d : devices) {
    const std::string api = fmt::format("{}.{}.{}", VK_API_VERSION_MAJOR(d.api_version),
                                        VK_API_VERSION_MINOR(d.api_version), VK_API_VERSION_PATCH(d.api_version));
    if (json) {
      out.push_back({{"index", d.index},
                     {"name", d.name},
                     {"type", d.type},
                     {"driver", d.driver},
                     {"vulkan", api},
                     {"memory_bytes", d.memory_bytes},
                     {"subgroup_size", d.subgroup_size},
                     {"missing", d.missing}});
    } else {
      print_result("{}  {}  [{}]  {}  Vulkan {}  {:.1f} GiB{}\n", d.index, d.name, d.type, d.driver, api,
                   static_cast<double>(d.memory_bytes) / (1 << 30),
                   d.missing.empty() ? "" : "  not usable: " + d.missing);
    }
  }
  if (json) {
    print_json(out);
  } else {
    print_result("reference  double-precision CPU reference\n");
  }
  return Ending::ok;
}

}  // namespace

void add_devices_command(Command& app, Action& action) {
  auto* command =
      app.add_subcommand("devices", "list the Vulkan devices and what is missing from those that cannot be used");
  const auto json = std::make_shared<bool>(false);
  command->add_flag("--json", *json, "machine-readable output");
  command->callback([&action, json] { action = [json] { return list(*json); }; });
}

}  // namespace etendue::cli
