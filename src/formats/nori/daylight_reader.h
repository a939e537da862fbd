#pragma once
/// <emitter> of a clear sky or its sun → Daylight.

#include "formats/dialect/daylight.h"
#include "formats/dialect/object.h"

namespace etendue {

/// Whether the type is one of them.
bool is_daylight(std::string_view type);

/// Problems are reported.
Daylight read_daylight(const Object& object, Diagnostics& sink);

}  // namespace etendue
