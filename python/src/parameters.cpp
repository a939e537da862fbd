/// What of a scene can be changed by name: camera, materials, lights, places, meshes.

#include <cstring>
#include <functional>
#include <map>
#include <variant>

#include "module.h"

namespace etendue::python {
namespace {

/// Gives every row of a table a name of its own: the path in its dictionary, or the name it has in its file, with a
/// number behind all but the first where several have that name.
class Names {
 public:
  std::string of(const SourcePosition& position, const std::string& name) {
    constexpr std::string_view kDictionary = "dict:/";
    std::string base = name.empty() ? "unnamed" : name;
    if (position.file.starts_with(kDictionary)) base = position.file.substr(kDictionary.size());
    for (char& c : base) {
      if (c == '/') c = '.';
    }
    const int number = ++used_[base];
    return number == 1 ? base : base + "_" + std::to_string(number);
  }

 private:
  std::map<std::string, int> used_;
};

using Numbers = nb::ndarray<nb::numpy, double>;

Numbers array_of(const double* values, std::initializer_list<std::size_t> shape) {
  std::size_t count = 1;
  for (const std::size_t side : shape) count *= side;
  auto* copy = new double[count];
  if (count > 0) std::memcpy(copy, values, count * sizeof(double));
  return Numbers(copy, shape, nb::capsule(copy, [](void* held) noexcept { delete[] static_cast<double*>(held); }));
}

/// Values for Python.
struct Getter {
  static nb::object of(bool value) { return nb::bool_(value); }
  static nb::object of(double value) { return nb::float_(value); }
  static nb::object of(std::uint32_t value) { return nb::int_(value); }
  static nb::object of(const glm::dvec3& value) { return nb::cast(array_of(&value.x, {3})); }
  static nb::object of(const ColorParameter& value) { return of(value.value); }
  static nb::object of(const ScalarParameter& value) { return of(value.value); }
  static nb::object of(const glm::dmat4& value) {
    const glm::dmat4 rows = glm::transpose(value);
    return nb::cast(array_of(&rows[0].x, {4, 4}));
  }
  static nb::object of(const VectorList& value) {
    const std::vector<glm::dvec3> rows(value.begin(), value.end());
    return nb::cast(array_of(rows.empty() ? nullptr : &rows.front().x, {rows.size(), 3}));
  }
};

[[noreturn]] void refuse(const std::string& name, const char* wanted) {
  throw Error(ErrorKind::usage, "'" + name + "' takes " + wanted + ".");
}

std::vector<double> numbers_of(const std::string& name, nb::handle value, const char* wanted) {
  std::vector<double> numbers;
  if (!nb::try_cast(value, numbers)) refuse(name, wanted);
  return numbers;
}

/// Values from Python: numbers, and lists of them. Python makes such lists of arrays.
struct Setter {
  const std::string& name;
  nb::handle value;

  void to(bool& target) const {
    if (!nb::try_cast(value, target)) refuse(name, "True or False");
  }
  void to(double& target) const {
    if (!nb::try_cast(value, target)) refuse(name, "a number");
  }
  void to(std::uint32_t& target) const {
    if (!nb::try_cast(value, target)) refuse(name, "a whole number, 0 to 2^32 - 1");
  }
  void to(glm::dvec3& target) const {
    constexpr const char* kWanted = "three numbers, or one for grey";
    double grey = 0;
    if (nb::try_cast(value, grey)) return void(target = glm::dvec3(grey));
    const std::vector<double> numbers = numbers_of(name, value, kWanted);
    if (numbers.size() != 3) refuse(name, kWanted);
    target = {numbers[0], numbers[1], numbers[2]};
  }
  void to(ColorParameter& target) const { to(target.value); }
  void to(ScalarParameter& target) const { to(target.value); }
  void to(glm::dmat4& target) const {
    constexpr const char* kWanted = "a matrix of 4 x 4 numbers";
    const std::vector<double> numbers = numbers_of(name, value, kWanted);
    if (numbers.size() != 16) refuse(name, kWanted);
    for (std::size_t i = 0; i < 16; ++i) target[static_cast<int>(i % 4)][static_cast<int>(i / 4)] = numbers[i];
  }
  void to(VectorList& target) const {
    nb::ndarray<const double, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu> rows;
    if (!nb::try_cast(value, rows) || (rows.shape(0) != target.size() && !target.empty()))
      refuse(name, "an array of as many rows of three numbers as there are vertices");
    std::vector<glm::dvec3> vectors(rows.shape(0));
    if (!vectors.empty()) std::memcpy(vectors.data(), rows.data(), vectors.size() * sizeof(glm::dvec3));
    target = std::move(vectors);
  }
};

/// Calls visit(name, value, view) for all that can be changed; `view`: nothing has to be compiled again for it.
template <class Visit>
void each_slot(Scene& scene, Visit&& visit) {
  const auto view = [&](const char* name, auto& value) { visit(std::string(name), value, true); };
  view("camera.width", scene.camera.width);
  view("camera.height", scene.camera.height);
  view("camera.fov", scene.camera.fov);
  view("camera.to_world", scene.camera.world_from_camera);
  view("camera.near_clip", scene.camera.near_clip);
  view("camera.far_clip", scene.camera.far_clip);
  view("camera.aperture_radius", scene.camera.aperture.radius);
  view("camera.focus_distance", scene.camera.aperture.focus_distance);
  view("sampler.sample_count", scene.sampler.sample_count);
  view("integrator.max_depth", scene.integrator.max_depth);
  view("integrator.rr_depth", scene.integrator.rr_depth);
  view("integrator.nee", scene.integrator.nee);
  view("integrator.mis", scene.integrator.mis);
  view("integrator.hide_emitters", scene.integrator.hide_emitters);
  view("integrator.hide_background", scene.integrator.hide_background);
  const auto slot = [&](const std::string& name, auto& value) { visit(name, value, false); };
  if (scene.sky.picture) {
    slot("sky.scale", scene.sky.picture->scale);
  } else {
    slot("sky.top", scene.sky.top);
    slot("sky.horizon", scene.sky.horizon);
  }
  Names materials, instances, lights;
  for (Material& material : scene.materials) {
    const std::string prefix = "materials." + materials.of(material.position, material.name) + ".";
    each_number(material, [&](const char* name, auto& value) { slot(prefix + name, value); });
  }
  for (Instance& instance : scene.instances) {
    const std::string prefix = "instances." + instances.of(instance.position, instance.name) + ".";
    slot(prefix + "to_world", instance.world_from_object);
    if (instance.emitter) slot(prefix + "radiance", scene.emitters[*instance.emitter].radiance);
    if (auto* mesh = std::get_if<TriangleMesh>(&scene.shapes[instance.shape])) {
      slot(prefix + "positions", mesh->positions);
      if (!mesh->normals.empty()) slot(prefix + "normals", mesh->normals);
    } else if (auto* sphere = std::get_if<Sphere>(&scene.shapes[instance.shape])) {
      slot(prefix + "center", sphere->center);
      slot(prefix + "radius", sphere->radius);
    }
  }
  for (DeltaLight& light : scene.delta_lights) {
    const std::string prefix = "lights." + lights.of(light.position, light.name) + ".";
    slot(prefix + "intensity", light.intensity);
    slot(prefix + "to_world", light.world_from_light);
  }
}

std::vector<std::string> names(const SceneHolder& holder) {
  std::vector<std::string> all;
  // The scene is only looked at; one visitor serves both.
  each_slot(const_cast<Scene&>(holder.scene()), [&](const std::string& name, auto&, bool) { all.push_back(name); });
  return all;
}

std::optional<nb::object> get(const SceneHolder& holder, const std::string& wanted) {
  std::optional<nb::object> found;
  each_slot(const_cast<Scene&>(holder.scene()), [&](const std::string& name, auto& value, bool) {
    if (name == wanted) found = Getter::of(value);
  });
  return found;
}

/// False where there is no such name.
bool set(SceneHolder& holder, const std::string& wanted, nb::handle value) {
  bool view_only = false, found = false;
  each_slot(const_cast<Scene&>(holder.scene()), [&](const std::string& name, auto&, bool view) {
    if (name == wanted) found = true, view_only = view;
  });
  if (!found) return false;
  each_slot(holder.change(view_only), [&](const std::string& name, auto& target, bool) {
    if (name == wanted) Setter{name, value}.to(target);
  });
  return true;
}

}  // namespace

void bind_parameters(nb::module_& m) {
  m.def("parameter_names", &names, nb::arg("scene"));
  m.def("get_parameter", &get, nb::arg("scene"), nb::arg("name"));
  m.def("set_parameter", &set, nb::arg("scene"), nb::arg("name"), nb::arg("value"));
}

}  // namespace etendue::python
