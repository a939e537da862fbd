#pragma once
/// What Etendue reads of Mitsuba's scenes: a row for each tag and type. docs/mitsuba.md prints it.

#include "formats/dialect/dialect.h"

namespace etendue {

/// Names of properties are those of Mitsuba 3; `snake_case` makes them of the older ones.
const Dialect& mitsuba_dialect();

/// "toWorld" → "to_world", "intIOR" → "int_ior"; what is so already stays.
std::string snake_case(std::string_view name);

/// A property that is read past: its row's text says why it does not matter.
bool has_no_effect(const Parameter& parameter);

}  // namespace etendue
