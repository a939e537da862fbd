#pragma once
/// A scene and what renderers make of it, made once for all of them.

#include <map>
#include <memory>
#include <mutex>
#include <typeindex>

#include "scene/scene.h"

namespace etendue {

/// Copies share the scene and what was made. What a renderer compiles of a scene it keeps here, so that another
/// renderer, on a second device or on one that was opened afresh, compiles nothing again. Safe to use from several
/// threads.
class SharedScene {
 public:
  /// Borrows: the scene must outlive every copy, and not change.
  SharedScene(
      const Scene& scene)  // NOLINT(google-explicit-constructor): a scene serves where a shared one is asked for
      : SharedScene(std::shared_ptr<const Scene>(std::shared_ptr<const Scene>(), &scene)) {}
  explicit SharedScene(std::shared_ptr<const Scene> scene)
      : scene_(std::move(scene)), cache_(std::make_shared<Cache>()) {}

  const Scene& scene() const { return *scene_; }

  /// The T that `make(scene())` makes. It is called once for each type T; who asks meanwhile waits.
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
