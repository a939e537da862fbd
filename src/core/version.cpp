#include "core/version.h"

namespace etendue {
const char* version() {
  return ETENDUE_VERSION;
}
}  // namespace etendue
