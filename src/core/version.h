#pragma once
namespace etendue {
/// "major.minor.patch" of this build.
const char* version();
}  // namespace etendue
