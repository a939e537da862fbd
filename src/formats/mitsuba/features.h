#pragma once
/// What a foreign scene asks for and Etendue does not have: collected over the whole file, so that one message names
/// all of it.

#include <map>
#include <set>
#include <string>
#include <vector>

#include "scene/diagnostics.h"

namespace etendue {

class MissingFeatures {
 public:
  explicit MissingFeatures(bool approximate) : approximate_(approximate) {}

  /// `what` as in "bsdf plastic"; `substitute` as in "a diffuse one of its colour".
  void add(const std::string& what, const SourcePosition& position, const std::string& substitute);

  /// Whether this is the first look at what an object holds that is not read itself.
  bool looks_into(const void* object) { return seen_.insert(object).second; }

  /// Where approximations are wanted a warning for each feature, else one error that lists them all.
  void report(const SourcePosition& scene, Diagnostics& diagnostics) const;

  /// "bsdf hair: diffuse, grey", for the metadata of pictures.
  std::vector<std::string> substitutes() const;

 private:
  struct Feature {
    std::string substitute;
    std::vector<SourcePosition> places;  ///< the first of them
    std::size_t count = 0;
  };
  std::string places_of(const Feature& feature) const;

  bool approximate_;
  std::map<std::string, Feature> features_;
  std::set<const void*> seen_;
};

}  // namespace etendue
