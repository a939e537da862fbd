/// What lives how long: the compiled scene outlives devices, views come and go on one renderer, and a device may belong
/// to the program around.

#include <algorithm>
#include <functional>

#include "core/errors.h"
#include "device_test.h"
#include "formats/read_scene.h"
#include "reference/reference_renderer.h"
#include "render/device_team.h"
#include "scene/material_numbers.h"
#include "validate/validate.h"

namespace etendue::test {
namespace {

class Lifetimes : public DeviceTest {
 protected:
  void SetUp() override {
    DeviceTest::SetUp();
    compilations_before_ = scene_compilations();
  }
  std::uint64_t compilations() const { return scene_compilations() - compilations_before_; }

 private:
  std::uint64_t compilations_before_ = 0;
};

Scene cornell() {
  return read_scene(SCENES_DIR "/cbox-sphere.xml",
                    {.overrides = {{"camera.width", "40"}, {"camera.height", "30"}}, .strict = true});
}

Film film_of(Renderer& renderer, const Scene& scene, const View& view, SampleRange range = {0, 3}) {
  Film film(view.camera.width, view.camera.height, [&] {
    Scene shown = scene;
    shown.camera = view.camera;
    shown.integrator = view.integrator;
    return film_exponent(shown);
  }());
  std::vector<RejectedSample> rejected;
  EXPECT_EQ(renderer.render(range, film, {}, rejected), range.end);
  return film;
}

// A renderer of its own, made of the scene as if it had always been looked at like that.
Film fresh_film(Scene scene, const View& view, const RenderSettings& settings, const GpuOptions& options) {
  scene.camera = view.camera;
  scene.sampler = view.sampler;
  scene.integrator = view.integrator;
  return film_of(*make_gpu_renderer(scene, settings, options), scene, view);
}

// Views that differ from the scene's own, each in one thing.
std::vector<std::pair<std::string, View>> other_views(const Scene& scene) {
  std::vector<std::pair<std::string, View>> views(8, {"", view_of(scene)});
  auto change = [&, i = std::size_t{0}](const char* what, const auto& make) mutable {
    views[i].first = what;
    make(views[i++].second);
  };
  change("larger", [](View& v) { v.camera.width = 71; });
  change("smaller", [](View& v) { v.camera.height = 9; });
  change("another camera", [](View& v) { v.camera.world_from_camera[3].x += 0.25; });
  change("another filter", [](View& v) { v.camera.filter.type = ReconstructionFilter::Type::mitchell; });
  change("shorter paths", [](View& v) { v.integrator.max_depth = 2; });
  change("no light sampling", [](View& v) { v.integrator.nee = false; });
  change("normals", [](View& v) { v.integrator.type = Integrator::Type::normals; });
  change("Sobol sets", [](View& v) { v.sampler = {Sampler::Type::sobol, 16, 2}; });
  return views;
}

TEST_F(Lifetimes, OneRendererTakesEveryViewAndCompilesTheSceneOnce) {
  const Scene scene = cornell();
  const View own = view_of(scene);
  const auto renderer = make_gpu_renderer(scene, {.seed = 1}, renderer_options());
  const Film first = film_of(*renderer, scene, own);
  std::vector<Film> films;
  for (const auto& [what, view] : other_views(scene)) {
    renderer->set_view(view, {.seed = 2});
    films.push_back(film_of(*renderer, scene, view));
  }
  renderer->set_view(own, {.seed = 1});
  EXPECT_EQ(film_of(*renderer, scene, own).pixels(), first.pixels()) << "the first view again";
  renderer->set_view(own, {.seed = 2});
  const Film reseeded = film_of(*renderer, scene, own);
  EXPECT_NE(reseeded.pixels(), first.pixels());
  EXPECT_EQ(compilations(), 1u);

  EXPECT_EQ(reseeded.pixels(), fresh_film(scene, own, {.seed = 2}, renderer_options()).pixels()) << "another seed";
  std::size_t i = 0;
  for (const auto& [what, view] : other_views(scene))
    EXPECT_EQ(films[i++].pixels(), fresh_film(scene, view, {.seed = 2}, renderer_options()).pixels()) << what;
}

TEST_F(Lifetimes, SamplesAndPathsFollowTheView) {
  const Scene scene = cornell();
  const auto renderer = make_gpu_renderer(scene, {.seed = 1}, renderer_options());
  const std::vector<SampleId> ids = {{5, 0}, {600, 1}, {1199, 2}};
  renderer->trace_samples(ids);
  renderer->trace_path(ids[1]);
  for (const auto& [what, view] : other_views(scene)) {
    if (what != "another camera" && what != "Sobol sets") continue;  // without and with another kernel
    renderer->set_view(view, {.seed = 3});
    Scene changed = scene;
    changed.camera = view.camera;
    changed.sampler = view.sampler;
    changed.integrator = view.integrator;
    const auto fresh = make_gpu_renderer(changed, {.seed = 3}, renderer_options());
    const auto got = renderer->trace_samples(ids), wanted = fresh->trace_samples(ids);
    for (std::size_t i = 0; i < ids.size(); ++i) {
      EXPECT_EQ(got[i].radiance, wanted[i].radiance) << what;
      EXPECT_EQ(got[i].signature, wanted[i].signature) << what;
    }
    EXPECT_EQ(renderer->trace_path(ids[1]).size(), fresh->trace_path(ids[1]).size()) << what;
  }
}

TEST_F(Lifetimes, TheReferenceFollowsTheView) {
  const Scene scene = cornell();
  const auto renderer = make_reference_renderer(scene, {.seed = 1});
  for (const auto& [what, view] : other_views(scene)) {
    renderer->set_view(view, {.seed = 3, .quantity = FilmQuantity::luminance});
    Scene changed = scene;
    changed.camera = view.camera;
    changed.sampler = view.sampler;
    changed.integrator = view.integrator;
    const auto fresh = make_reference_renderer(changed, {.seed = 3, .quantity = FilmQuantity::luminance});
    EXPECT_EQ(film_of(*renderer, scene, view).pixels(), film_of(*fresh, scene, view).pixels()) << what;
  }
}

// One of each kind: a number, a colour, a table of their own, and glass that gets a tint, for which a kernel is built.
Scene with_materials() {
  Scene scene = cornell();
  scene.materials.push_back({RoughPlasticBsdf{}, {}, "plastic", {}});
  scene.materials.push_back({DielectricBsdf{}, {}, "glass", {}});
  scene.materials.push_back({DiffuseBsdf{}, {}, "paper", {}});
  const auto paper = static_cast<std::uint32_t>(scene.materials.size() - 1);
  scene.materials.push_back({{}, BlendAdapter{{0.25}, paper, paper - 2}, "mixture", {}});
  for (std::uint32_t i = 0; i < 3; ++i)
    scene.add(Sphere{.center = {0.4 * i - 0.4, 0.3, 0.8}, .radius = 0.15}).material =
        i == 2 ? paper + 1 : paper - 2 + i;
  return scene;
}

std::vector<std::vector<Material>> changed_materials(const Scene& scene) {
  std::vector<std::vector<Material>> all;
  const auto change = [&](const char* material, const char* number, const glm::dvec3& value) {
    std::vector<Material> materials = all.empty() ? scene.materials : all.back();
    const auto found = std::ranges::find(materials, material, &Material::name);
    ASSERT_NE(found, materials.end());
    ASSERT_TRUE(set_number(*found, number, value));
    all.push_back(std::move(materials));
  };
  change("paper", "albedo", {0.9, 0.1, 0.2});
  change("plastic", "alpha", glm::dvec3(0.4));
  change("plastic", "int_ior", glm::dvec3(1.9));
  change("glass", "specular_transmittance", {0.3, 0.9, 0.6});
  change("glass", "int_ior", glm::dvec3(1.2));
  change("mixture", "weight", glm::dvec3(0.8));
  return all;
}

TEST_F(Lifetimes, MaterialsGetOtherNumbersAndNothingOfTheSceneIsCompiledAgain) {
  const Scene scene = with_materials();
  const auto renderer = make_gpu_renderer(scene, {.seed = 1}, renderer_options());
  const auto reference = make_reference_renderer(scene, {.seed = 1});
  const Film first = film_of(*renderer, scene, view_of(scene));
  std::vector<Film> films;
  for (const std::vector<Material>& materials : changed_materials(scene)) {
    renderer->set_materials(materials);
    films.push_back(film_of(*renderer, scene, view_of(scene)));
  }
  EXPECT_EQ(compilations(), 1u);
  std::size_t i = 0;
  for (const std::vector<Material>& materials : changed_materials(scene)) {
    Scene changed = scene;
    changed.materials = materials;
    EXPECT_NE(films[i].pixels(), (i == 0 ? first : films[i - 1]).pixels()) << i;
    EXPECT_EQ(films[i].pixels(), fresh_film(changed, view_of(scene), {.seed = 1}, renderer_options()).pixels()) << i;
    reference->set_materials(materials);
    EXPECT_EQ(film_of(*reference, scene, view_of(scene), {0, 1}).pixels(),
              film_of(*make_reference_renderer(changed, {.seed = 1}), scene, view_of(scene), {0, 1}).pixels())
        << i;
    ++i;
  }
  renderer->set_materials(scene.materials);
  EXPECT_EQ(film_of(*renderer, scene, view_of(scene)).pixels(), first.pixels()) << "the scene's own again";
}

BlendAdapter& mixture_of(std::vector<Material>& all) {
  return std::get<BlendAdapter>(*std::ranges::find(all, "mixture", &Material::name)->adapter);
}

TEST_F(Lifetimes, MaterialsOfOtherKindsOrOutOfRangeAreRefused) {
  const Scene scene = with_materials();
  const auto device = make_gpu_renderer(scene, {.seed = 1}, renderer_options());
  const auto reference = make_reference_renderer(scene, {.seed = 1});
  const auto refused = [&](ErrorKind kind, const std::function<void(std::vector<Material>&)>& change) {
    std::vector<Material> materials = scene.materials;
    change(materials);
    for (Renderer* renderer : {device.get(), reference.get()}) {
      try {
        renderer->set_materials(materials);
        ADD_FAILURE() << "taken by " << renderer->device_name();
      } catch (const Error& error) {
        EXPECT_EQ(error.kind(), kind) << error.what();
      }
    }
  };
  refused(ErrorKind::usage, [](auto& all) { all.pop_back(); });
  refused(ErrorKind::usage, [](auto& all) { all[0].bsdf = MirrorBsdf{}; });
  refused(ErrorKind::usage, [](auto& all) { mixture_of(all).first = 0; });
  refused(ErrorKind::scene, [](auto& all) { mixture_of(all).weight = 1.5; });
  EXPECT_EQ(film_of(*device, scene, view_of(scene)).pixels(),
            fresh_film(scene, view_of(scene), {.seed = 1}, renderer_options()).pixels())
      << "what was refused changes nothing";
}

TEST_F(Lifetimes, OneRendererTakesOneSceneAfterTheOther) {
  const auto renderer = make_gpu_renderer(cornell(), {.seed = 1}, renderer_options());
  const auto reference = make_reference_renderer(cornell(), {.seed = 1});
  std::vector<Scene> scenes = {cornell(), with_materials(), cornell()};
  scenes[2].instances.back().world_from_object[3].y += 0.05;
  scenes[2].camera.width = 25;
  for (const Scene& scene : scenes) {
    renderer->set_scene(scene, {.seed = 2});
    reference->set_scene(scene, {.seed = 2});
    EXPECT_EQ(film_of(*renderer, scene, view_of(scene)).pixels(),
              fresh_film(scene, view_of(scene), {.seed = 2}, renderer_options()).pixels());
    EXPECT_EQ(film_of(*reference, scene, view_of(scene), {0, 1}).pixels(),
              film_of(*make_reference_renderer(scene, {.seed = 2}), scene, view_of(scene), {0, 1}).pixels());
  }
}

TEST_F(Lifetimes, LightsKeepTheirTreeWhenLightSamplingIsTurnedOn) {
  Scene scene =
      read_scene(SCENES_DIR "/thousand-lamps.xml", {.overrides = {{"camera.width", "24"}, {"camera.height", "16"}}});
  View with_nee = view_of(scene);
  scene.integrator.nee = false;
  const auto renderer = make_gpu_renderer(scene, {.seed = 1}, renderer_options());
  film_of(*renderer, scene, view_of(scene));
  renderer->set_view(with_nee, {.seed = 1});
  EXPECT_EQ(film_of(*renderer, scene, with_nee).pixels(),
            fresh_film(scene, with_nee, {.seed = 1}, renderer_options()).pixels());
}

TEST_F(Lifetimes, TwoDevicesAndALostOneShareWhatIsCompiled) {
  const Scene scene = cornell();
  const SharedScene shared(scene);
  // The first device is lost at its first pass, as a driver would lose it; then it is opened afresh.
  int opened = 0;
  class Lost : public Renderer {
   public:
    explicit Lost(std::unique_ptr<Renderer> inner) : inner_(std::move(inner)) {}
    std::string device_name() const override { return inner_->device_name(); }
    std::string driver_name() const override { return inner_->driver_name(); }
    void set_view(const View& view, const RenderSettings& settings) override { inner_->set_view(view, settings); }
    void set_materials(const std::vector<Material>& materials) override { inner_->set_materials(materials); }
    void set_scene(const SharedScene& scene, const RenderSettings& settings) override {
      inner_->set_scene(scene, settings);
    }
    std::uint32_t render(SampleRange, Film&, const Progress&, std::vector<RejectedSample>&) override {
      throw DeviceLost("The device was lost.");
    }
    std::vector<SampleRecord> trace_samples(std::span<const SampleId>) override { return {}; }
    std::vector<PathVertex> trace_path(SampleId) override { return {}; }

   private:
    std::unique_ptr<Renderer> inner_;
  };
  const auto open = [&]() -> std::unique_ptr<Renderer> {
    auto renderer = make_gpu_renderer(shared, {.seed = 1}, renderer_options());
    if (opened++ == 0) return std::make_unique<Lost>(std::move(renderer));
    return renderer;
  };
  DeviceTeam team({open, open});
  SampleQueue queue({{0, 16}});
  Film film(40, 30, film_exponent(scene));
  team.render(
      queue, 40, 30, film_exponent(scene), [&](const FinishedSamples& f) { film.merge(*f.film); },
      [](std::uint64_t) { return true; });
  EXPECT_GE(opened, 3);
  EXPECT_EQ(compilations(), 1u);
  EXPECT_EQ(
      film.pixels(),
      film_of(*make_gpu_renderer(scene, {.seed = 1}, renderer_options()), scene, view_of(scene), {0, 16}).pixels());
}

TEST_F(Lifetimes, ValidationCompilesOnce) {
  const Scene scene = cornell();
  ValidateOptions options;
  options.samples_per_pixel = 16;
  options.sample_budget = 2000;
  const Validation v = validate_scene(
      scene,
      [](const SharedScene& s, const RenderSettings& settings) {
        return make_gpu_renderer(s, settings, renderer_options());
      },
      [](const SharedScene& s, const RenderSettings& settings) { return make_reference_renderer(s.scene(), settings); },
      options);
  EXPECT_TRUE(v.passed()) << validation_text(v);
  EXPECT_EQ(compilations(), 1u);
}

TEST_F(Lifetimes, RenderersShareASceneOnTheDevice) {
  const Scene scene = cornell();
  const GpuOptions options = renderer_options();
  const auto on_device = std::make_shared<const DeviceScene>(
      open_device(options), std::make_shared<const CompiledScene>(compile_scene(scene)));
  View small = view_of(scene);
  small.camera.width = 16;
  const auto a = make_gpu_renderer(on_device, view_of(scene), {.seed = 1}, options);
  const auto b = make_gpu_renderer(on_device, small, {.seed = 2}, options);
  for (int turn = 0; turn < 2; ++turn) {
    EXPECT_EQ(film_of(*a, scene, view_of(scene)).pixels(),
              fresh_film(scene, view_of(scene), {.seed = 1}, options).pixels());
    EXPECT_EQ(film_of(*b, scene, small).pixels(), fresh_film(scene, small, {.seed = 2}, options).pixels());
  }
}

// On a CPU: the compiled scene lives as long as a buffer of its pages, and no longer.
TEST_F(Lifetimes, TheTreeIsReadWhereItIs) {
  const Scene scene = cornell();
  const GpuOptions options = renderer_options();
  const std::shared_ptr<GpuDevice> device = open_device(options);
  auto compiled = std::make_shared<const CompiledScene>(compile_scene(scene));
  const std::weak_ptr<const CompiledScene> watched = compiled;
  auto on_device = std::make_shared<const DeviceScene>(device, compiled);
  auto others = std::make_shared<const DeviceScene>(*on_device, *compiled, *compiled, *compiled);
  compiled.reset();
  EXPECT_EQ(watched.expired(), device->context->host_memory_alignment() == 0);
  EXPECT_TRUE(!is_lavapipe() || device->context->host_memory_alignment() != 0);
  on_device.reset();
  EXPECT_EQ(film_of(*make_gpu_renderer(others, view_of(scene), {.seed = 1}, options), scene, view_of(scene)).pixels(),
            fresh_film(scene, view_of(scene), {.seed = 1}, options).pixels());
  others.reset();
  EXPECT_TRUE(watched.expired());
}

// Only whole pages are read in place.
TEST_F(Lifetimes, MemoryWithinAPageIsNoBuffer) {
  const auto device = open_device(renderer_options());
  const auto owner = std::make_shared<const PageVector<std::byte>>(3 * kPageBytes, std::byte{7});
  const std::span<const std::byte> bytes(*owner);
  const auto in_place = [&](std::span<const std::byte> part) {
    return vulkan::Buffer::in_place(*device->context, owner, part, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, "test")
        .has_value();
  };
  EXPECT_EQ(in_place(bytes), device->context->host_memory_alignment() != 0);
  EXPECT_FALSE(in_place(bytes.subspan(64)));
  EXPECT_FALSE(in_place(bytes.first(0)));
}

TEST_F(Lifetimes, TheFilmStaysOnTheDevice) {
  const Scene scene = cornell();
  const auto renderer = make_gpu_renderer(scene, {.seed = 1}, renderer_options());
  Film film = film_of(*renderer, scene, view_of(scene), {0, 3});
  const vulkan::MemoryUse before = vulkan::memory_use();
  vulkan::reset_memory_peak();
  film.merge(film_of(*renderer, scene, view_of(scene), {3, 6}));
  EXPECT_EQ(vulkan::memory_use().peak, before.now) << "nothing new was allocated";
  EXPECT_EQ(
      film.pixels(),
      film_of(*make_gpu_renderer(scene, {.seed = 1}, renderer_options()), scene, view_of(scene), {0, 6}).pixels());
}

TEST_F(Lifetimes, AFilmOfAnotherViewIsRefused) {
  const Scene scene = cornell();
  const auto renderer = make_gpu_renderer(scene, {}, renderer_options());
  std::vector<RejectedSample> rejected;
  for (Film film :
       {Film(41, 30, film_exponent(scene)), Film(40, 29, film_exponent(scene)), Film(40, 30, film_exponent(scene) + 1)})
    EXPECT_THROW(renderer->render({0, 1}, film, {}, rejected), Error);
}

// A device as another program would open it, without the help of vulkan::Context.
struct ForeignProgram {
  ForeignProgram() {
    const VkApplicationInfo application{.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .apiVersion = VK_API_VERSION_1_2};
    const VkInstanceCreateInfo instance_info{.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                             .pApplicationInfo = &application};
    EXPECT_EQ(vkCreateInstance(&instance_info, nullptr, &instance), VK_SUCCESS);
    std::uint32_t count = 1;
    vkEnumeratePhysicalDevices(instance, &count, &device.physical);
    EXPECT_EQ(count, 1u);
    const float priority = 1.0f;
    const VkDeviceQueueCreateInfo queue{.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                        .queueFamilyIndex = 0,
                                        .queueCount = 1,
                                        .pQueuePriorities = &priority};
    const VkPhysicalDeviceFeatures features{.robustBufferAccess = VK_TRUE};
    const VkDeviceCreateInfo info{.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                  .queueCreateInfoCount = 1,
                                  .pQueueCreateInfos = &queue,
                                  .pEnabledFeatures = &features};
    EXPECT_EQ(vkCreateDevice(device.physical, &info, nullptr, &device.device), VK_SUCCESS);
    vkGetDeviceQueue(device.device, 0, 0, &device.queue);
  }
  ~ForeignProgram() {
    vkDestroyDevice(device.device, nullptr);
    vkDestroyInstance(instance, nullptr);
  }
  VkInstance instance = VK_NULL_HANDLE;
  vulkan::ForeignDevice device;
};

TEST_F(Lifetimes, ADeviceOfTheProgramAroundIsUsedAndLeftOpen) {
  if (!is_lavapipe()) GTEST_SKIP() << "family 0 may have no compute queue";
  const Scene scene = cornell();
  const ForeignProgram program;
  for (int turn = 0; turn < 2; ++turn) {
    GpuOptions options = renderer_options();
    options.open = std::make_shared<const vulkan::Context>(program.device, options.context);
    const auto renderer = make_gpu_renderer(scene, {.seed = 1}, options);
    EXPECT_EQ(film_of(*renderer, scene, view_of(scene)).pixels(),
              fresh_film(scene, view_of(scene), {.seed = 1}, renderer_options()).pixels());
  }
  EXPECT_EQ(vkDeviceWaitIdle(program.device.device), VK_SUCCESS);
}

}  // namespace
}  // namespace etendue::test
