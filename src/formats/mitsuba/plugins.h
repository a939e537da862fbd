#pragma once
/// What Etendue reads in Mitsuba scenes: a row for each tag and type. docs/mitsuba.md contains this table.

#include "formats/dialect/dialect.h"

namespace etendue {

/// Properties have their names of Mitsuba 3; `snake_case` converts the older names.
const Dialect& mitsuba_dialect();

/// "toWorld" → "to_world", "intIOR" → "int_ior"; names that are in snake case already stay the same.
std::string snake_case(std::string_view name);

/// Whether a property is ignored; its description says why it does not matter.
bool has_no_effect(const Parameter& parameter);

}  // namespace etendue
