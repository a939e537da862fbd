#include "formats/gltf/byte_store.h"

#include <algorithm>
#include <utility>

#include "formats/input_file.h"

namespace etendue {
namespace {

class FileStore final : public ByteStore {
 public:
  explicit FileStore(const std::string& path) : file_(path) {}
  std::uint64_t size() const override { return file_.size(); }
  void read(std::uint64_t offset, std::span<std::byte> to) const override {
    file_.read_at(offset, reinterpret_cast<char*>(to.data()), to.size());
  }

 private:
  InputFile file_;
};

class MemoryStore final : public ByteStore {
 public:
  explicit MemoryStore(std::vector<std::byte> bytes) : bytes_(std::move(bytes)) {}
  std::uint64_t size() const override { return bytes_.size(); }
  void read(std::uint64_t offset, std::span<std::byte> to) const override {
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(offset), to.size(), to.begin());
  }

 private:
  std::vector<std::byte> bytes_;
};

class PartStore final : public ByteStore {
 public:
  PartStore(std::shared_ptr<const ByteStore> whole, std::uint64_t offset, std::uint64_t size)
      : whole_(std::move(whole)), offset_(offset), size_(size) {}
  std::uint64_t size() const override { return size_; }
  void read(std::uint64_t offset, std::span<std::byte> to) const override { whole_->read(offset_ + offset, to); }

 private:
  std::shared_ptr<const ByteStore> whole_;
  std::uint64_t offset_, size_;
};

}  // namespace

std::vector<std::byte> ByteStore::read(std::uint64_t offset, std::uint64_t count) const {
  std::vector<std::byte> bytes(count);
  read(offset, bytes);
  return bytes;
}

std::shared_ptr<const ByteStore> open_store(const std::string& path) {
  return std::make_shared<FileStore>(path);
}

std::shared_ptr<const ByteStore> memory_store(std::vector<std::byte> bytes) {
  return std::make_shared<MemoryStore>(std::move(bytes));
}

std::shared_ptr<const ByteStore> part_of(std::shared_ptr<const ByteStore> whole, std::uint64_t offset,
                                         std::uint64_t size) {
  return std::make_shared<PartStore>(std::move(whole), offset, size);
}

}  // namespace etendue
