#include "gpu/device_film.h"

#include <algorithm>
#include <cstring>

#include "gpu_types.h"

namespace etendue {

static_assert(sizeof(FilmPixel) == sizeof(gpu::FilmSlot));

SlotLayout::SlotLayout(std::uint32_t w, std::uint32_t h, std::uint32_t samples, std::uint32_t wanted_slots)
    : width(w),
      height(h),
      tiles_x((w + gpu::kTileSize - 1) / gpu::kTileSize),
      tiles_y((h + gpu::kTileSize - 1) / gpu::kTileSize) {
  const std::uint64_t pixels = std::uint64_t{w} * h;
  const std::uint64_t wanted = (wanted_slots + pixels - 1) / pixels;
  layers = static_cast<std::uint32_t>(std::clamp<std::uint64_t>(wanted, 1, std::max(1u, samples)));
}

std::uint64_t SlotLayout::groups() const {
  if (!packed()) return std::uint64_t{tiles_x} * tiles_y;
  return (std::uint64_t{pixels()} * layers + gpu::kWorkgroupSize - 1) / gpu::kWorkgroupSize;
}

std::uint32_t SlotLayout::pixel(std::uint64_t group, std::uint32_t lane) const {
  if (packed()) {
    const std::uint64_t slot = group * gpu::kWorkgroupSize + lane;
    return slot < std::uint64_t{pixels()} * layers ? static_cast<std::uint32_t>(slot % pixels()) : ~0u;
  }
  const auto tile = static_cast<std::uint32_t>(group);
  const std::uint32_t x = tile % tiles_x * gpu::kTileSize + lane % gpu::kTileSize;
  const std::uint32_t y = tile / tiles_x * gpu::kTileSize + lane / gpu::kTileSize;
  return x < width && y < height ? y * width + x : ~0u;
}

std::uint32_t SlotLayout::layer(std::uint64_t group, std::uint32_t lane) const {
  return packed() ? static_cast<std::uint32_t>((group * gpu::kWorkgroupSize + lane) / pixels()) : 0;
}

DeviceNeed film_need(const SlotLayout& layout) {
  constexpr std::uint64_t kBytesPerSlot = sizeof(gpu::FilmSlot);
  return {"film", layout.groups() * gpu::kWorkgroupSize * kBytesPerSlot, DeviceNeed::Kind::memory};
}

std::uint32_t max_groups_per_band(const vulkan::Context& context) {
  constexpr std::uint64_t kBytesPerGroup = sizeof(gpu::FilmSlot) * gpu::kWorkgroupSize;
  const DeviceNeed least{"film tile", kBytesPerGroup, DeviceNeed::Kind::storage};
  check_needs({&least, 1}, limits_of(context));
  return static_cast<std::uint32_t>(context.limits().maxStorageBufferRange / kBytesPerGroup);
}

FilmBand::FilmBand(const vulkan::Context& context, std::uint32_t first_group, std::uint32_t group_count,
                   bool with_set_sums)
    : first_group_(first_group), group_count_(group_count) {
  const auto buffer = [&](std::size_t bytes_per_slot, const char* what) {
    return vulkan::Buffer(context, std::uint64_t{group_count} * gpu::kWorkgroupSize * bytes_per_slot,
                          VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, vulkan::Buffer::Memory::device, what);
  };
  slots_ = buffer(sizeof(gpu::FilmSlot), "film");
  if (with_set_sums) set_sums_ = buffer(sizeof(gpu::vec4), "sums over sets");
}

void FilmBand::begin(vulkan::Commands& commands) {
  commands.fill(slots_, 0);
  if (set_sums_) commands.fill(*set_sums_, 0);
}

void FilmBand::bind(vulkan::BindingSet& set) const {
  set.bind(gpu::kBindingFilm, slots_);
  if (set_sums_) set.bind(gpu::kBindingSetSums, *set_sums_);
}

void FilmBand::add_to(vulkan::Commands& commands, const SlotLayout& layout, Film& film) const {
  constexpr std::uint32_t kGroupsPerChunk = 1024;
  std::vector<FilmPixel> slots;
  for (std::uint32_t done = 0; done < group_count_; done += kGroupsPerChunk) {
    const std::uint32_t groups = std::min(kGroupsPerChunk, group_count_ - done);
    slots.resize(std::size_t{groups} * gpu::kWorkgroupSize);
    commands.download(slots_, std::uint64_t{done} * gpu::kWorkgroupSize * sizeof(FilmPixel),
                      std::as_writable_bytes(std::span(slots)));
    for (std::size_t i = 0; i < slots.size(); ++i) {
      const std::uint32_t pixel = layout.pixel(first_group_ + done + i / gpu::kWorkgroupSize,
                                               static_cast<std::uint32_t>(i % gpu::kWorkgroupSize));
      if (pixel != ~0u) film.pixels()[pixel].merge(slots[i]);
    }
  }
}

DeviceFilm::DeviceFilm(std::shared_ptr<GpuDevice> device, const SlotLayout& layout, std::uint32_t set_bits)
    : device_(std::move(device)), layout_(layout), set_bits_(set_bits) {
  const std::uint32_t per_band = max_groups_per_band(*device_->context);
  for (std::uint64_t first = 0; first < layout.groups(); first += per_band) {
    const auto count = static_cast<std::uint32_t>(std::min<std::uint64_t>(per_band, layout.groups() - first));
    bands_.emplace_back(*device_->context, static_cast<std::uint32_t>(first), count, set_bits > 0);
  }
}

void DeviceFilm::begin() {
  for (FilmBand& band : bands_) band.begin(device_->commands);
}

void DeviceFilm::add_to(Film& film) const {
  for (const FilmBand& band : bands_) band.add_to(device_->commands, layout_, film);
}

}  // namespace etendue
