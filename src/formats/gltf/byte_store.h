#pragma once
/// Bytes of a glTF asset, in a file or in memory, that are read in pieces: a file of gigabytes need not fit into
/// memory.

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
  /// The caller must have checked that the range is within the store. Throws Error(file).
  virtual void read(std::uint64_t offset, std::span<std::byte> to) const = 0;

  std::vector<std::byte> read(std::uint64_t offset, std::uint64_t count) const;
};

/// Opens a file. Throws the same errors as InputFile.
std::shared_ptr<const ByteStore> open_store(const std::string& path);
std::shared_ptr<const ByteStore> memory_store(std::vector<std::byte> bytes);
/// A part of another store; the range must be within that store.
std::shared_ptr<const ByteStore> part_of(std::shared_ptr<const ByteStore> whole, std::uint64_t offset,
                                         std::uint64_t size);

}  // namespace etendue
