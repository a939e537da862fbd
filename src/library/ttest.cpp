#include "etendue/ttest.h"

#include <vector>

#include <fmt/core.h>

#include "core/errors.h"
#include "gpu/bsdf_probe.h"
#include "library/device_selection.h"
#include "reference/material_probe.h"
#include "validate/chi2.h"

namespace etendue {

TTestReport run_ttest(const TTest& test, const std::string& file, const DeviceSelection& device,
                      const TTestOptions& options) {
  const std::vector<RendererFactory> factories = renderer_factories(device);
  if (factories.size() != 1)
    throw Error(ErrorKind::usage,
                fmt::format("'{}' names {} devices, but a t-test runs on one.", device.selector, factories.size()));
  if (test.bsdfs.empty()) return run_ttest(test, file, factories.front(), options);
  if (device.selector == "reference") return run_bsdf_ttest(test, file, make_reference_bsdf_probe, options);
  const auto probe = [gpu = gpu_options(device)](const Bsdf& bsdf) { return make_gpu_bsdf_probe(bsdf, gpu); };
  return run_bsdf_ttest(test, file, probe, options);
}

}  // namespace etendue
