#pragma once
/// Collects everything that a foreign scene asks for and Etendue does not have, so that one message can name all of it.

#include <map>
#include <set>
#include <string>
#include <vector>

#include "scene/diagnostics.h"

namespace etendue {

class MissingFeatures {
 public:
  explicit MissingFeatures(bool approximate) : approximate_(approximate) {}

  /// `what`: for example "bsdf plastic"; `substitute`: for example "a diffuse one of its colour".
  void add(const std::string& what, const SourcePosition& position, const std::string& substitute);

  /// True the first time that an object is passed: its content must be listed only once.
  bool looks_into(const void* object) { return seen_.insert(object).second; }

  /// Reports a warning for each feature if approximations are allowed, otherwise one error that lists them all.
  void report(const SourcePosition& scene, Diagnostics& diagnostics) const;

  /// For the metadata of pictures: "bsdf hair: diffuse, grey".
  std::vector<std::string> substitutes() const;

 private:
  struct Feature {
    std::string substitute;
    std::vector<SourcePosition> places;  ///< the first few
    std::size_t count = 0;
  };
  std::string places_of(const Feature& feature) const;

  bool approximate_;
  std::map<std::string, Feature> features_;
  std::set<const void*> seen_;
};

}  // namespace etendue
