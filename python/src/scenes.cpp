#include "module.h"

namespace etendue::python {
namespace {

SceneHolder holder_of(std::optional<SceneFile> file, const Diagnostics& diagnostics, const std::string& path) {
  if (!file || diagnostics.has_errors()) throw ReadFailure(diagnostics.list());
  auto* scene = std::get_if<Scene>(&*file);
  if (scene == nullptr)
    throw Error(ErrorKind::scene, path + ": the file holds a <test>, not a <scene>; run it with ttest().");
  return SceneHolder(std::move(*scene), diagnostics.list());
}

GltfLamps lamps_of(const std::string& word) {
  if (word == "auto") return GltfLamps::automatic;
  if (word == "blender") return GltfLamps::blender;
  if (word == "standard") return GltfLamps::standard;
  if (word == "watts") return GltfLamps::watts;
  throw Error(ErrorKind::usage, "There is no lamps='" + word + "'; there are: auto, blender, standard, watts.");
}

SceneHolder read(const std::string& path, const std::vector<std::pair<std::string, std::string>>& parameters,
                 bool strict, bool approximate, const std::string& environment, const std::string& camera,
                 std::optional<double> at, const std::string& asset_scene, const std::string& animation,
                 const std::string& variant, const std::string& lamps) {
  const ReadOptions options{.overrides = parameters,
                            .strict = strict,
                            .approximate = approximate,
                            .environment = environment,
                            .camera = camera,
                            .at = at,
                            .scene = asset_scene,
                            .animation = animation,
                            .variant = variant,
                            .lamps = lamps_of(lamps)};
  Diagnostics diagnostics;
  std::optional<SceneFile> file;
  run_waiting([&] {
    file = read_scene_file(path, options, diagnostics);
    if (file) check_scene_file(*file, diagnostics);
    diagnostics.log_warnings();
  });
  return holder_of(std::move(file), diagnostics, path);
}

void set_size(SceneHolder& holder, std::pair<std::uint32_t, std::uint32_t> size) {
  Camera& camera = holder.change(true).camera;
  camera.width = size.first;
  camera.height = size.second;
}

std::vector<std::string> aovs_of(const SceneHolder& holder) {
  std::vector<std::string> names;
  for (const Aov aov : holder.scene().aovs) {
    if (aov != Aov::hit) names.emplace_back(traits(aov).name);
  }
  return names;
}

void set_aovs(SceneHolder& holder, const std::vector<std::string>& names) {
  std::vector<Aov> aovs = aovs_named(names);
  holder.change(true).aovs = std::move(aovs);
}

std::uint64_t primitives_of(const SceneHolder& holder) {
  std::uint64_t count = 0;
  for (const Instance& instance : holder.scene().instances) count += primitive_count(holder.scene().shape_of(instance));
  return count;
}

}  // namespace

std::vector<Aov> aovs_named(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list.empty() ? std::vector<Aov>{} : parse_aovs(list);
}

Scene& SceneHolder::change(bool view_only) {
  if (!reading_.expired())
    throw Error(ErrorKind::usage,
                "This scene is being rendered; end the render (close a progressive one), or change a copy().");
  if (!view_only) compiled_.reset();
  return *scene_;
}

std::shared_ptr<const SharedScene> SceneHolder::read() {
  if (!compiled_) compiled_.emplace(std::shared_ptr<const Scene>(scene_));
  std::shared_ptr<const SharedScene> reading = reading_.lock();
  if (!reading) reading_ = reading = std::make_shared<const SharedScene>(*compiled_);
  return reading;
}

void bind_scenes(nb::module_& m) {
  nb::class_<SceneHolder>(m, "Scene")
      .def("__init__", [](SceneHolder* self) { new (self) SceneHolder(Scene{}); })
      .def("copy", [](const SceneHolder& holder) { return SceneHolder(holder.scene(), holder.findings()); })
      .def_prop_rw(
          "name", [](const SceneHolder& h) { return h.scene().name; },
          [](SceneHolder& h, const std::string& name) { h.change(true).name = name; })
      .def_prop_ro("file", [](const SceneHolder& h) { return h.scene().file; })
      .def_prop_ro("findings", [](const SceneHolder& h) { return findings_of(h.findings()); })
      .def_prop_ro("approximations", [](const SceneHolder& h) { return h.scene().approximations; })
      .def_prop_ro("hash", [](const SceneHolder& h) { return scene_hash(h.scene()); })
      .def_prop_rw(
          "size", [](const SceneHolder& h) { return std::pair(h.scene().camera.width, h.scene().camera.height); },
          &set_size)
      .def_prop_rw(
          "spp", [](const SceneHolder& h) { return h.scene().sampler.sample_count; },
          [](SceneHolder& h, std::uint32_t spp) { h.change(true).sampler.sample_count = spp; })
      .def_prop_rw("aovs", &aovs_of, &set_aovs)
      .def_prop_ro("primitive_count", &primitives_of)
      .def("check", [](const SceneHolder& h) {
        Diagnostics diagnostics;
        check_invariants(h.scene(), diagnostics);
        return findings_of(diagnostics.list());
      });
  m.def("read_scene", &read, nb::arg("path"), nb::arg("parameters"), nb::arg("strict"), nb::arg("approximate"),
        nb::arg("environment"), nb::arg("camera"), nb::arg("at").none(), nb::arg("scene"), nb::arg("animation"),
        nb::arg("variant"), nb::arg("lamps"));
}

}  // namespace etendue::python
