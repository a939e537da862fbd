#include "gpu/device_view.h"

#include <span>

namespace etendue {

DeviceView::DeviceView(GpuDevice& device)
    : frame_(*device.context, sizeof(gpu::Frame), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, vulkan::Buffer::Memory::device,
             "frame constants"),
      filter_(*device.context, (gpu::kFilterSteps + 1) * sizeof(float), VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT,
              vulkan::Buffer::Memory::device, "reconstruction filter"),
      filter_view_(vulkan::make_texel_view(*device.context, filter_, VK_FORMAT_R32_SFLOAT)) {}

void DeviceView::set(GpuDevice& device, const CompiledView& view) {
  device.commands.upload(frame_, 0, std::as_bytes(std::span(&view.frame, 1)));
  if (!view.filter_knots.empty()) device.commands.upload(filter_, 0, std::as_bytes(std::span(view.filter_knots)));
}

void DeviceView::bind(vulkan::BindingSet& set) const {
  set.bind(gpu::kBindingFrame, frame_);
  set.bind(gpu::kBindingFilter, filter_view_);
}

}  // namespace etendue
