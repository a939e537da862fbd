#pragma once
/// Film slots in device memory, and copying them back into a Film.

#include <optional>
#include <vector>

#include "gpu/device_limits.h"
#include "gpu/gpu_device.h"
#include "image/film.h"
#include "render/renderer.h"
#include "vulkan/kernel.h"

namespace etendue {

/// How pixels map to film slots. Slots are usually 8 × 8 tiles, row by row. If an image has too few pixels to fill the
/// device, slots are packed and each pixel has several: slot i belongs to pixel i % pixels and takes every `layers`-th
/// of its samples (sums are integers, so adding slots up later changes nothing).
struct SlotLayout {
  std::uint32_t width = 0, height = 0;
  std::uint32_t tiles_x = 0, tiles_y = 0;
  std::uint32_t layers = 1;

  SlotLayout(std::uint32_t width, std::uint32_t height, std::uint32_t samples, std::uint32_t wanted_slots);
  bool packed() const { return layers > 1; }
  std::uint32_t pixels() const { return width * height; }
  std::uint64_t groups() const;
  bool operator==(const SlotLayout&) const = default;
  /// Pixel of lane `lane` of group `group`, or ~0u for padding.
  std::uint32_t pixel(std::uint64_t group, std::uint32_t lane) const;
  /// Index of the slot among those of its pixel; 0 for padding.
  std::uint32_t layer(std::uint64_t group, std::uint32_t lane) const;
};

/// A run of workgroups whose slots fit into one storage buffer.
class FilmBand {
 public:
  FilmBand(const vulkan::Context& context, std::uint32_t first_group, std::uint32_t group_count, bool with_set_sums);
  /// Clears all slots.
  void begin(vulkan::Commands& commands);
  std::uint32_t first_group() const { return first_group_; }
  std::uint32_t group_count() const { return group_count_; }
  void bind(vulkan::BindingSet& set) const;
  /// Adds every slot to its pixel.
  void add_to(vulkan::Commands& commands, const SlotLayout& layout, Film& film) const;

 private:
  std::uint32_t first_group_, group_count_;
  vulkan::Buffer slots_;
  std::optional<vulkan::Buffer> set_sums_;  // over unfinished sets, where a set is more than one path
};

/// The slots of a whole film, in bands; kept from one render to the next.
class DeviceFilm {
 public:
  DeviceFilm(std::shared_ptr<GpuDevice> device, const SlotLayout& layout, std::uint32_t set_bits);
  /// True if these buffers suit a film of this layout.
  bool fits(const SlotLayout& layout, std::uint32_t set_bits) const {
    return layout == layout_ && set_bits == set_bits_;
  }
  void begin();
  const SlotLayout& layout() const { return layout_; }
  const std::vector<FilmBand>& bands() const { return bands_; }
  void add_to(Film& film) const;

 private:
  std::shared_ptr<GpuDevice> device_;
  SlotLayout layout_;
  std::uint32_t set_bits_;
  std::vector<FilmBand> bands_;
};

/// Device memory of a film.
DeviceNeed film_need(const SlotLayout& layout);

/// Workgroups whose slots fit into one binding of the device.
std::uint32_t max_groups_per_band(const vulkan::Context& context);

}  // namespace etendue
