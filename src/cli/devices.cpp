#include <fmt/core.h>
#include "cli/command.h"
#include "cli/result_files.h"
#include "cli/results.h"
#include "core/json.h"
#include "vulkan/context.h"

namespace etendue::cli {
namespace {

Ending list(const ResultOptions& results) {
  results.begin();
  const auto devices = vulkan::list_devices(gpu_context_options());
  auto out = Json::array();
  const vulkan::DeviceInfo* first = nullptr;  // what 'auto' takes
  for (const vulkan::DeviceInfo& d : devices) {
    if (d.missing.empty() && (first == nullptr || d.rank < first->rank)) first = &d;
  }
  for (const vulkan::DeviceInfo& d : devices) {
    const std::string api = fmt::format("{}.{}.{}", VK_API_VERSION_MAJOR(d.api_version),
                                        VK_API_VERSION_MINOR(d.api_version), VK_API_VERSION_PATCH(d.api_version));
    out.push_back({{"index", d.index},
                   {"name", d.name},
                   {"type", d.type},
                   {"driver", d.driver},
                   {"vulkan", api},
                   {"memory_bytes", d.memory_bytes},
                   {"subgroup_size", d.subgroup_size},
                   {"missing", d.missing},
                   {"ray_queries", d.ray_queries},
                   {"auto", &d == first}});
    if (results.wants_text()) {
      print_result("{}  {}  [{}]  {}  Vulkan {}  {:.1f} GiB{}{}\n", d.index, d.name, d.type, d.driver, api,
                   static_cast<double>(d.memory_bytes) / (1 << 30), d.ray_queries ? "  ray queries" : "",
                   d.missing.empty() ? "" : "  not usable: " + d.missing);
    }
  }
  if (results.wants_text()) print_result("reference  double-precision CPU reference\n");
  OutputWriter files;
  results.write_json(files, [&] { return out; });
  files.finish();
  return Ending::ok;
}

}  // namespace

void add_devices_command(Command& app, Action& action) {
  auto* command = app.add_subcommand("devices", "list the Vulkan devices and what the unusable ones lack");
  const auto results = std::make_shared<ResultOptions>();
  results->add_to(*command);
  command->callback([&action, results] { action = [results] { return list(*results); }; });
}

}  // namespace etendue::cli
