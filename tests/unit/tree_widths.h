#pragma once
/// Tests of the wide tree ask the same of both widths, whichever the kernels are built for: TYPED_TESTs over
/// TreeWidths, whose TypeParam::value is the width.

#include <cstdint>
#include <string>
#include <type_traits>

#include <gtest/gtest.h>

namespace etendue::test {

using TreeWidths = ::testing::Types<std::integral_constant<std::uint32_t, 4>, std::integral_constant<std::uint32_t, 8>>;

struct TreeWidthNames {
  template <typename Width>
  static std::string GetName(int) {
    return std::to_string(Width::value) + "Wide";
  }
};

}  // namespace etendue::test
