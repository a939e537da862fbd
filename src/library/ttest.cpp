#include "etendue/ttest.h"

#include <vector>

#include <fmt/core.h>

#include "core/errors.h"
#include "library/device_selection.h"
#include "validate/chi2.h"

namespace etendue {

TTestReport run_ttest(const TTest& test, const std::string& file, const DeviceSelection& device,
                      const TTestOptions& options) {
  const std::vector<RendererFactory> factories = renderer_factories(device);
  if (factories.size() != 1)
    throw Error(ErrorKind::usage,
                fmt::format("'{}' names {} devices, but a t-test runs on one.", device.selector, factories.size()));
  if (test.bsdfs.empty()) return run_ttest(test, file, factories.front(), options);
  return run_bsdf_ttest(test, file, bsdf_probe_factory(device), options);
}

}  // namespace etendue
