#pragma once
/// Bytes of a glTF asset that are read in pieces, wherever they lie: gigabytes of a file need not be in memory at once.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace etendue {

class ByteStore {
 public:
  virtual ~ByteStore() = default;
  virtual std::uint64_t size() const = 0;
  /// The range lies within the store: the caller has checked. Throws Error(file).
  virtual void read(std::uint64_t offset, std::span<std::byte> to) const = 0;

  std::vector<std::byte> read(std::uint64_t offset, std::uint64_t count) const;
};

/// Throws Error as InputFile does.
std::shared_ptr<const ByteStore> open_store(const std::string& path);
std::shared_ptr<const ByteStore> memory_store(std::vector<std::byte> bytes);
/// A part of another store, within it.
std::shared_ptr<const ByteStore> part_of(std::shared_ptr<const ByteStore> whole, std::uint64_t offset,
                                         std::uint64_t size);

}  // namespace etendue
