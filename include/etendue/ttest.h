#pragma once
/// Comparison with theory: the t-tests of a file with a `<test type="ttest">`.

#include <string>

#include "etendue/render.h"
#include "validate/ttest.h"

namespace etendue {

/// Runs the tests, of scenes or of materials, of a file that read_scene_file() has read; `file` is for the report.
/// Throws Error(usage) if the selector names several devices or if the numbers of references and scenes differ, and
/// whatever a renderer throws.
TTestReport run_ttest(const TTest& test, const std::string& file, const DeviceSelection& device,
                      const TTestOptions& options = {});

}  // namespace etendue
