#pragma once
/// A scene, with the data that renderers compile from it once for all of them.

#include <map>
#include <memory>
#include <mutex>
#include <typeindex>

#include "scene/scene.h"

namespace etendue {

/// Copies share the scene and the compiled data. Renderers store their compiled data here, so that another renderer, on
/// a second device or on a reopened one, does not compile them again. Thread-safe.
class SharedScene {
 public:
  /// Borrows: the scene must outlive every copy, and not change.
  SharedScene(
      const Scene& scene)  // NOLINT(google-explicit-constructor): a scene serves where a shared one is asked for
      : SharedScene(std::shared_ptr<const Scene>(std::shared_ptr<const Scene>(), &scene)) {}
  explicit SharedScene(std::shared_ptr<const Scene> scene)
      : scene_(std::move(scene)), cache_(std::make_shared<Cache>()) {}

  const Scene& scene() const { return *scene_; }

  /// The T made by `make(scene())`. It is called once for each type T; concurrent callers wait.
  template <typename T, typename Make>
  std::shared_ptr<const T> once(const Make& make) const {
    const std::lock_guard lock(cache_->mutex);
    std::shared_ptr<const void>& made = cache_->made[std::type_index(typeid(T))];
    if (!made) made = std::make_shared<const T>(make(*scene_));
    return std::static_pointer_cast<const T>(made);
  }

 private:
  struct Cache {
    std::mutex mutex;
    std::map<std::type_index, std::shared_ptr<const void>> made;
  };
  std::shared_ptr<const Scene> scene_;
  std::shared_ptr<Cache> cache_;
};

}  // namespace etendue
