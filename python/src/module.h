#pragma once
/// What the files of the module share. It is a thin layer: the work is the library's, what users see is written in
/// Python beside it.

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <etendue/etendue.h>

namespace etendue::python {

namespace nb = nanobind;

/// The findings of a reader that could not make a scene of a file.
class ReadFailure : public Error {
 public:
  explicit ReadFailure(std::vector<Diagnostic> findings);
  const std::vector<Diagnostic>& findings() const { return findings_; }

 private:
  std::vector<Diagnostic> findings_;
};

/// A finding as Python sees it: severity, sentence, file, line, column (0 where unknown).
using Finding = std::tuple<std::string, std::string, std::string, int, int>;
std::vector<Finding> findings_of(const std::vector<Diagnostic>& diagnostics);

/// AOVs by their names. Throws Error(usage) for others.
std::vector<Aov> aovs_named(const std::vector<std::string>& names);

/// A scene that Python may change while no render reads it.
class SceneHolder {
 public:
  explicit SceneHolder(Scene scene, std::vector<Diagnostic> findings = {})
      : scene_(std::make_shared<Scene>(std::move(scene))), findings_(std::move(findings)) {}

  const Scene& scene() const { return *scene_; }
  const std::vector<Diagnostic>& findings() const { return findings_; }
  /// For a change. Throws Error(usage) while a render reads it. What was compiled of it is forgotten, unless only
  /// what a View holds is changed (scene/view.h).
  Scene& change(bool view_only);
  /// The scene with what renderers compile of it, which is kept for the next render. It counts as being read until the
  /// result and its copies are gone.
  std::shared_ptr<const SharedScene> read();

 private:
  std::shared_ptr<Scene> scene_;
  std::optional<SharedScene> compiled_;
  std::weak_ptr<const SharedScene> reading_;
  std::vector<Diagnostic> findings_;
};

/// A picture, and the film it shows if it was rendered.
struct Picture {
  std::shared_ptr<const FilmFile> film;  ///< null: there is none
  std::shared_ptr<const Image> image;

  explicit Picture(FilmFile of)
      : film(std::make_shared<const FilmFile>(std::move(of))),
        image(std::make_shared<const Image>(picture_of(*film))) {}
  explicit Picture(Image of) : image(std::make_shared<const Image>(std::move(of))) {}
};

/// What a computation in another thread is told, and tells.
struct Control {
  std::atomic<bool> stop{false};
  std::atomic<std::uint64_t> done{0};  ///< of `total`
  std::uint64_t total = 0;             ///< 0: nothing to be told
};

/// Runs `work` in a thread of its own, while this one waits without the GIL and looks every twentieth of a second for
/// signals: what a handler raises sets `stop` and is returned, when the work has ended. `progress(done, total)` is
/// called meanwhile, if it is not None; what it raises is taken like that. Nothing is returned where nothing was
/// raised; what `work` throws is thrown.
nb::object run_interruptibly(const std::function<void()>& work, Control& control, const nb::object& progress);
/// The same for what cannot be stopped: what a handler raises is raised when it has ended.
void run_waiting(const std::function<void()>& work);

/// Sends what the library had to say to Python's logger "etendue". With the GIL.
void deliver_messages();

void bind_errors(nb::module_& m);
void bind_pictures(nb::module_& m);
void bind_scenes(nb::module_& m);
void bind_objects(nb::module_& m);
void bind_parameters(nb::module_& m);
void bind_renders(nb::module_& m);
void bind_verdicts(nb::module_& m);

}  // namespace etendue::python
