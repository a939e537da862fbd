#include "scene/vector_list.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace etendue {
namespace {

bool is_single(double value) {
  // A conversion beyond the range is undefined.
  return std::abs(value) <= double{std::numeric_limits<float>::max()} &&
         static_cast<double>(static_cast<float>(value)) == value;
}

}  // namespace

std::vector<glm::dvec3>& VectorList::edit() {
  if (!narrow_.empty()) {
    wide_.assign(narrow_.begin(), narrow_.end());
    narrow_ = {};
  }
  return wide_;
}

void VectorList::narrow() {
  const auto fits = [](const glm::dvec3& v) { return is_single(v.x) && is_single(v.y) && is_single(v.z); };
  if (!std::ranges::all_of(wide_, fits)) {
    wide_.shrink_to_fit();
    return;
  }
  narrow_.reserve(narrow_.size() + wide_.size());
  for (const glm::dvec3& v : wide_) narrow_.emplace_back(v);
  wide_ = {};
}

bool operator==(const VectorList& a, const VectorList& b) {
  return std::ranges::equal(a, b);
}

}  // namespace etendue
