#pragma once
/// What a picture should be, by theory: the t-tests of a file with a `<test type="ttest">`.

#include <string>

#include "etendue/render.h"
#include "validate/ttest.h"

namespace etendue {

/// Runs the tests of a file that read_scene_file() has read, of scenes or of materials; `file` is for the report.
/// Throws Error(usage) when the selector names several devices or references and scenes differ in number, and whatever
/// a renderer throws.
TTestReport run_ttest(const TTest& test, const std::string& file, const DeviceSelection& device,
                      const TTestOptions& options = {});

}  // namespace etendue
