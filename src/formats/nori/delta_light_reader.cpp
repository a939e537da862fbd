#include "formats/nori/delta_light_reader.h"

#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "core/text.h"
#include "image/vectors.h"

namespace etendue {
namespace {

class DeltaLightReader {
 public:
  DeltaLightReader(const Object& object, const std::function<ColorParameter(const Object&, const char*)>& read_textured,
                   Diagnostics& sink)
      : object_(object), read_textured_(read_textured), sink_(sink) {}

  DeltaLight read() {
    const std::string_view type = object_.plugin().type;
    light_.name = type;
    light_.position = object_.position();
    light_.world_from_light = object_.matrix("toWorld");
    if (type == "point") {
      light_.type = DeltaLight::Type::point;
      read_place();
      read_intensity(4.0 * kPi);
    } else if (type == "spot") {
      light_.type = DeltaLight::Type::spot;
      read_place();
      read_direction();
      read_cone();
      const double outer = std::cos(light_.cutoff * kPi / 180.0), inner = std::cos(light_.beam_width * kPi / 180.0);
      read_intensity(2.0 * kPi * (1.0 - 0.5 * (outer + inner)));
    } else if (type == "projector") {
      light_.type = DeltaLight::Type::projector;
      light_.intensity = textured("irradiance");
      light_.intensity.value *= object_.get<double>("scale");
      const double half = std::tan(object_.get<double>("fov") * kPi / 360.0);
      light_.slope = {half, half / object_.get<double>("aspect")};
    } else {
      light_.type = DeltaLight::Type::directional;
      read_direction();
      if (const char* name = one_of("irradiance", "radiance")) light_.intensity = object_.get<glm::dvec3>(name);
    }
    if (type != "projector") light_.intensity.value *= object_.get<double>("scale");
    return light_;
  }

 private:
  ColorParameter textured(const char* property) {
    if (object_.child_of(property) != nullptr) return read_textured_(object_, property);
    return object_.get<glm::dvec3>(property);
  }

  /// The one of two properties that is given; exactly one must be.
  const char* one_of(const char* first, const char* second) {
    if (object_.given(first) && object_.given(second)) {
      sink_.error(object_.position_of(second),
                  fmt::format("the {} has both \"{}\" and \"{}\"; keep one of them", light_.name, first, second));
    }
    if (object_.given(first)) return first;
    if (object_.given(second)) return second;
    sink_.error(object_.position(), fmt::format("the {} has neither \"{}\" nor \"{}\"; add <color name=\"{}\" "
                                                "value=\"1 1 1\"/>",
                                                light_.name, first, second, first));
    return nullptr;
  }

  /// Of a spot, in the words of some courses.
  bool has_color() const { return object_.given("color"); }
  /// Whether the light is of a kind that has the property, and it is given.
  bool has(const char* name) const { return object_.plugin().find(name) != nullptr && object_.given(name); }
  bool has_theta() const { return has("theta") || has("thetaMax"); }

  void read_intensity(double solid_angle) {
    if (has_color()) {
      for (const char* other : {"intensity", "power"}) {
        if (object_.given(other)) one_of(other, "color");  // an error
      }
      light_.intensity = object_.get<glm::dvec3>("color") / (4.0 * kPi);
      return;
    }
    const char* name = one_of("intensity", "power");
    if (name == nullptr) return;
    if (name == std::string_view("intensity")) {
      light_.intensity = textured("intensity");
    } else {
      light_.intensity = object_.get<glm::dvec3>("power") / (has_theta() ? 1.0 : solid_angle);
    }
  }

  void refuse_with_transform(const char* property) {
    if (object_.given("toWorld"))
      sink_.error(object_.position_of(property),
                  fmt::format("the {} has both \"{}\" and \"toWorld\", which means the same; keep one of them",
                              light_.name, property));
  }

  /// With thetaMax, toWorld turns a light toward -Z that stays where it is.
  bool turns_in_place() const { return has("thetaMax") && object_.given("toWorld"); }

  void read_place() {
    if (turns_in_place()) {
      light_.world_from_light[0] *= -1.0;
      light_.world_from_light[2] *= -1.0;
    }
    if (!object_.given("position")) return;
    if (!turns_in_place()) refuse_with_transform("position");
    light_.world_from_light[3] = glm::dvec4(object_.get<glm::dvec3>("position"), 1.0);
  }

  /// Any frame whose +Z is the direction.
  void read_direction() {
    const bool has_target = object_.plugin().find("target") != nullptr && object_.given("target");
    if (!has_target && !object_.given("direction")) return;
    const char* property = has_target ? "target" : "direction";
    if (has_target && object_.given("direction"))
      sink_.error(object_.position_of("target"),
                  fmt::format("the {} has both \"direction\" and \"target\"; keep one of them", light_.name));
    refuse_with_transform(property);
    glm::dvec3 z = object_.get<glm::dvec3>(property);
    if (has_target) z -= light_.origin();
    const double length = glm::length(z);
    if (!(length > 0.0)) {
      sink_.error(object_.position_of(property),
                  has_target ? fmt::format("the target of the {} is at its position; move one of them", light_.name)
                             : fmt::format("the direction of the {} is 0 0 0; give one", light_.name));
      return;
    }
    z /= length;
    const glm::dvec3 helper = std::abs(z.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
    const glm::dvec3 x = glm::normalize(glm::cross(helper, z));
    light_.world_from_light[0] = glm::dvec4(x, 0.0);
    light_.world_from_light[1] = glm::dvec4(glm::cross(z, x), 0.0);
    light_.world_from_light[2] = glm::dvec4(z, 0.0);
  }

  /// The two half angles of the cone that the words of a convention give, in degrees.
  struct Cone {
    const char *outer, *inner;
  };

  /// Exactly one convention may be used.
  Cone cone_words() {
    const Cone all[] = {{"cutoffAngle", "beamWidth"},
                        {"totalWidth", "falloffStart"},
                        {"cosTotalWidth", "cosFalloffStart"},
                        {"theta", "thetaFalloff"},
                        {"thetaMax", "thetaFall"}};
    const Cone* used = nullptr;
    for (const Cone& cone : all) {
      if (!object_.given(cone.outer) && !object_.given(cone.inner)) continue;
      if (used != nullptr) {
        const char* name = object_.given(used->outer) ? used->outer : used->inner;
        const char* other = object_.given(cone.outer) ? cone.outer : cone.inner;
        sink_.error(object_.position_of(name),
                    fmt::format("\"{}\" and \"{}\" are two names for one cone; keep one pair of them", name, other));
      }
      used = &cone;
    }
    return used == nullptr ? all[0] : *used;
  }

  /// A half angle in degrees, from any of the words.
  double half_angle(const char* name) const {
    const auto value = object_.get<double>(name);
    const std::string_view word = name;
    if (word == "theta" || word == "thetaFalloff") return 0.5 * value;
    // Some courses mean the cosines, as the words say, and others degrees.
    if (word.starts_with("cos") && value <= 1.0) return std::acos(value) * 180.0 / kPi;
    return value;
  }

  void read_cone() {
    const Cone words = cone_words();
    const bool other = std::string_view(words.outer) != "cutoffAngle";
    const char* beam = words.inner;
    light_.cutoff = object_.given(words.outer) ? half_angle(words.outer) : object_.get<double>("cutoffAngle");
    light_.beam_width = object_.given(beam) ? half_angle(beam) : 0.75 * light_.cutoff;
    if (light_.beam_width > light_.cutoff) {
      // With these names courses' own lights have a hard edge; a cutoffAngle must be what it says.
      const std::string what = fmt::format("the beam of the spot has a half angle of {} degrees, its cone one of {}; ",
                                           light_.beam_width, light_.cutoff);
      if (other)
        sink_.warning(object_.position_of(beam), what + "the light ends with the cone, at a hard edge");
      else
        sink_.error(object_.position_of(beam), what + "the beam must be within the cone");
      light_.beam_width = light_.cutoff;
    }
    read_falloff(other);
  }

  void read_falloff(bool other) {
    light_.falloff = other && !has_color() && !has_theta() ? DeltaLight::Falloff::quartic : DeltaLight::Falloff::linear;
    if (!object_.given("falloff")) return;
    const auto word = object_.get<std::string>("falloff");
    if (word == "linear") {
      light_.falloff = DeltaLight::Falloff::linear;
    } else if (word == "smooth") {
      light_.falloff = DeltaLight::Falloff::smooth;
    } else if (word == "quartic") {
      light_.falloff = DeltaLight::Falloff::quartic;
    } else {
      const std::vector<std::string> known = {"linear", "smooth", "quartic"};
      sink_.error(object_.position_of("falloff"),
                  fmt::format("{} is not a kind of falloff{}; known are linear, smooth and quartic", text::quoted(word),
                              text::did_you_mean(word, known)));
    }
  }

  const Object& object_;
  const std::function<ColorParameter(const Object&, const char*)>& read_textured_;
  Diagnostics& sink_;
  DeltaLight light_;
};

}  // namespace

bool is_delta_light(std::string_view type) {
  return type == "point" || type == "spot" || type == "projector" || type == "directional" || type == "distant";
}

DeltaLight read_delta_light(const Object& object,
                            const std::function<ColorParameter(const Object&, const char*)>& read_textured,
                            Diagnostics& sink) {
  return DeltaLightReader(object, read_textured, sink).read();
}

}  // namespace etendue
