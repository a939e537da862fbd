#pragma once
/// Vectors in double precision that take half the memory if all of them are exact in single precision, as those of most
/// mesh files are.

#include <cstddef>
#include <initializer_list>
#include <iterator>
#include <utility>
#include <vector>

#include <glm/glm.hpp>

namespace etendue {

class VectorList {
 public:
  class Iterator;
  using value_type = glm::dvec3;
  using iterator = Iterator;
  using const_iterator = Iterator;

  VectorList() = default;
  VectorList(std::vector<glm::dvec3> vectors) : wide_(std::move(vectors)) {}
  VectorList(std::initializer_list<glm::dvec3> vectors) : wide_(vectors) {}
  explicit VectorList(std::vector<glm::vec3> vectors) : narrow_(std::move(vectors)) {}

  std::size_t size() const { return narrow_.empty() ? wide_.size() : narrow_.size(); }
  bool empty() const { return narrow_.empty() && wide_.empty(); }
  /// `const`, since an assignment to what is returned would change nothing.
  const glm::dvec3 operator[](std::size_t i) const { return narrow_.empty() ? wide_[i] : glm::dvec3(narrow_[i]); }
  const glm::dvec3 at(std::size_t i) const { return narrow_.empty() ? wide_.at(i) : glm::dvec3(narrow_.at(i)); }
  Iterator begin() const;
  Iterator end() const;

  /// The vectors, to be changed: in double precision from now on.
  std::vector<glm::dvec3>& edit();
  void push_back(const glm::dvec3& v) { edit().push_back(v); }
  template <typename... Args>
  void emplace_back(Args&&... args) {
    edit().emplace_back(std::forward<Args>(args)...);
  }
  void reserve(std::size_t count) { edit().reserve(count); }
  void clear() { *this = VectorList(); }

  /// Keeps the vectors in single precision if this changes none of them.
  void narrow();
  /// What the vectors take, not counting what was reserved for more.
  std::size_t bytes() const { return wide_.size() * sizeof(glm::dvec3) + narrow_.size() * sizeof(glm::vec3); }

 private:
  // At most one of them is not empty.
  std::vector<glm::dvec3> wide_;
  std::vector<glm::vec3> narrow_;
};

class VectorList::Iterator {
 public:
  using iterator_category = std::input_iterator_tag;  // there is nothing to refer to
  using iterator_concept = std::forward_iterator_tag;
  using value_type = glm::dvec3;
  using difference_type = std::ptrdiff_t;
  using pointer = void;
  using reference = const glm::dvec3;

  Iterator() = default;
  Iterator(const VectorList& list, std::size_t at) : list_(&list), at_(at) {}
  reference operator*() const { return (*list_)[at_]; }
  Iterator& operator++() {
    ++at_;
    return *this;
  }
  Iterator operator++(int) { return std::exchange(*this, Iterator(*list_, at_ + 1)); }
  bool operator==(const Iterator& other) const { return at_ == other.at_; }

 private:
  const VectorList* list_ = nullptr;
  std::size_t at_ = 0;
};

inline VectorList::Iterator VectorList::begin() const {
  return {*this, 0};
}
inline VectorList::Iterator VectorList::end() const {
  return {*this, size()};
}
bool operator==(const VectorList& a, const VectorList& b);

}  // namespace etendue
