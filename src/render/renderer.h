#pragma once
/// The interface of both renderers: a pure function of (scene, seed, sample range). Callers choose a renderer and never
/// look inside.

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "image/film.h"
#include "render/shared_scene.h"
#include "scene/scene.h"
#include "scene/view.h"

namespace etendue {

/// Half-open range of sample indices; each index is one sample of every pixel.
struct SampleRange {
  std::uint32_t begin = 0;
  std::uint32_t end = 0;
  std::uint32_t count() const { return end - begin; }
};

/// What the film accumulates. `luminance` replaces each sample by (Y, Y, Y): the t-test needs the variance of
/// luminance.
enum class FilmQuantity { color, luminance };

struct RenderSettings {
  std::uint32_t seed = 0;
  FilmQuantity quantity = FilmQuantity::color;
};

/// One sample of one pixel.
struct SampleId {
  std::uint32_t pixel = 0;  ///< y · width + x
  std::uint32_t sample = 0;
};

/// Result of one sample; `signature` is a hash of its decisions (docs/conventions.md, "Path signature").
struct SampleRecord {
  glm::vec3 radiance{0.0f};
  std::uint32_t signature = 0;
  std::uint32_t segments = 0;  ///< segments traced, shadow rays not counted
};

/// One segment of a path and the decisions at its end; `kNone` where nothing was decided.
struct PathVertex {
  static constexpr std::uint32_t kNone = 0xffffffffu;
  static constexpr std::uint32_t kEnvironment = 0xfffffffeu;  ///< as light_instance: light from outside
  static constexpr std::uint32_t kDeltaLight = 0xfffffffdu;   ///< as light_instance: a light without extent
  std::uint32_t instance = kNone;                             ///< kNone: the ray left the scene
  std::uint32_t primitive = kNone;                            ///< triangle in the mesh, 0 for a sphere
  std::uint32_t light_instance = kNone;
  std::uint32_t light_primitive = kNone;    ///< for the environment its cell, for a light without extent its number
  std::uint32_t light_contributed = kNone;  ///< 0 or 1
  std::uint32_t lobe = kNone;               ///< one of reference::Lobe, kLobe… on devices
  std::uint32_t survived = kNone;           ///< 0 or 1
  glm::vec3 from{0.0f};                     ///< where the segment begins, world space
  glm::vec3 to{0.0f};                       ///< where it ends; of a ray that left the scene its direction
  glm::vec3 radiance{0.0f};                 ///< accumulated up to and including this vertex
};

/// A non-finite or out-of-range sample, located.
struct RejectedSample {
  SampleId id;
  std::uint32_t segments = 0;  ///< path length at which it ended
};

/// Called from time to time with the number of pixel samples done in this call; returns false to stop after the current
/// pass.
using Progress = std::function<bool(std::uint64_t done, std::uint64_t total)>;

class Renderer {
 public:
  virtual ~Renderer() = default;

  /// Name of the device and driver as written to image headers, for example "llvmpipe (LLVM 15.0.6, 256 bits)" /
  /// "Mesa 22.3.6".
  virtual std::string device_name() const = 0;
  virtual std::string driver_name() const = 0;

  /// Changes the camera, film size, sampler, integrator or seed for subsequent renders. Does not recompile the scene.
  /// Throws what making a renderer throws.
  virtual void set_view(const View& view, const RenderSettings& settings) = 0;

  /// From now on, renders with other numbers in the scene's materials. Does not recompile the scene; a kernel is built
  /// if the change needs a feature that no kernel has yet. Throws Error(usage) if more than numbers has changed
  /// (exchange_complaint() in scene/material_numbers.h), Error(scene) for numbers that check_materials() refuses, and
  /// Error(lost).
  virtual void set_materials(const std::vector<Material>& materials) = 0;

  /// From now on, renders a scene that differs from the present one only in the radiance and intensity of its lights,
  /// in its sky and in numbers of its materials, with its own view. Its shapes are not compiled again. Throws what
  /// set_scene() and set_materials() throw; after that, the renderer must not be used.
  virtual void set_lights(const SharedScene& scene, const RenderSettings& settings) { set_scene(scene, settings); }

  /// From now on, renders another scene, with its own view, on the same open device. A kernel is built only if the
  /// scenes differ in constants of kernels. Throws what making a renderer throws; after that, the renderer must not be
  /// used.
  virtual void set_scene(const SharedScene& scene, const RenderSettings& settings) = 0;

  /// Adds samples [range.begin, end) of every pixel to `film` and returns `end`: range.end, or less if `progress` asked
  /// to stop. It adds exactly the samples of whole indices. Rejected samples are listed in `rejected` (the first 64).
  virtual std::uint32_t render(SampleRange range, Film& film, const Progress& progress,
                               std::vector<RejectedSample>& rejected) = 0;

  /// Evaluates single samples, in the given order.
  virtual std::vector<SampleRecord> trace_samples(std::span<const SampleId> ids) = 0;

  /// The decisions of one path, vertex by vertex (at most 256).
  virtual std::vector<PathVertex> trace_path(SampleId id) = 0;
};

}  // namespace etendue
