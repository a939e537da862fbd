#pragma once
/// Instance, physical devices and one logical device with a compute queue.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "vulkan/handle.h"
#include "vulkan/module_cache.h"

namespace etendue::vulkan {

/// Facts about a physical device that are known before it is opened.
struct DeviceInfo {
  std::uint32_t index = 0;  ///< in the order of vkEnumeratePhysicalDevices; what --device takes
  std::string name;
  std::string driver;  ///< driver name and version text
  std::string type;    ///< "discrete GPU", "integrated GPU", "virtual GPU", "CPU" or "other"
  std::uint32_t api_version = 0;
  std::uint64_t memory_bytes = 0;  ///< largest device-local heap
  int rank = 0;                    ///< see device_rank: 'auto' takes the least
  std::uint32_t subgroup_size = 0;
  bool subgroup_ballot = false;  ///< compute kernels can query which lanes of a subgroup are active
  bool ray_queries = false;      ///< kernels can query the driver for hits
  std::string missing;           ///< why it cannot be used; empty if it can
};

/// What the kernels of a program require of a device, apart from Vulkan 1.2 and a compute queue.
struct Requirements {
  std::uint32_t sets = 0;             ///< descriptor sets bound at a time
  std::uint32_t storage_buffers = 0;  ///< bound to one kernel
  std::uint32_t sampled_images = 0;   ///< likewise; texel buffers are among them
  std::uint32_t uniform_buffers = 0;  ///< likewise
  std::uint32_t push_constant_bytes = 0;
  std::uint32_t uniform_bytes = 0;  ///< size of the largest uniform buffer
  std::uint32_t workgroup_lanes = 0;
  /// The extensions and features of ray queries, which are enabled only if this is set.
  bool ray_queries = false;

  /// The first requirement that `limits` do not meet, in words; empty if they meet all.
  std::string missing(const VkPhysicalDeviceLimits& limits) const;
};

/// Options of the Vulkan instance, and requirements on its devices.
struct ContextOptions {
  /// Loads the Khronos validation layer (an error if it is not installed). Every message is counted and logged.
  bool validation = false;
  /// Adds synchronization and GPU-assisted validation.
  bool validation_extra = false;
  /// Upper bound of the time any submission may take.
  double max_wait_seconds = 300.0;
  /// Keeps specialized and compiled kernels in files in the user's cache folder.
  bool pipeline_cache = true;
  /// Opens devices so that their compiler tells what it made of kernels (Kernel::statistics), and uses no cache. It
  /// takes VK_KHR_pipeline_executable_properties: a device without it is an Error(device).
  bool kernel_statistics = false;
  Requirements requirements;
  /// True when the environment variable ETENDUE_VALIDATION is "1", or "2" for the extra kinds.
  static ContextOptions from_environment();
};

class Instance;

/// The order in which 'auto' takes devices, the least first: discrete, integrated and virtual GPUs, other hardware,
/// then CPU drivers, with Mesa's before all others and SwiftShader, at a fortieth of its speed, last.
int device_rank(VkPhysicalDeviceType type, VkDriverId driver);

/// Every physical device, usable or not. Throws Error(device) if there is no Vulkan loader.
std::vector<DeviceInfo> list_devices(const ContextOptions& options);

/// A device that the calling program has opened, and will close after its last use here.
struct ForeignDevice {
  VkPhysicalDevice physical = VK_NULL_HANDLE;
  VkDevice device = VK_NULL_HANDLE;  ///< opened with the feature robustBufferAccess
  VkQueue queue = VK_NULL_HANDLE;    ///< of a family with compute; nobody else may submit to it meanwhile
  std::uint32_t queue_family = 0;
  /// Opened with VK_KHR_acceleration_structure, VK_KHR_ray_query and their features, and bufferDeviceAddress.
  bool ray_queries = false;
};

/// An open device. Not thread-safe: one thread submits at a time. Several may be open, each used by a thread of its
/// own.
class Context {
 public:
  /// `selector`: "auto" (the first by device_rank), an index, or a part of the name (case-insensitive).
  /// Throws Error(device) saying why each device was rejected.
  Context(const std::string& selector, const ContextOptions& options);
  /// Uses a device without owning it. Throws Error(device) saying what it lacks.
  Context(const ForeignDevice& foreign, const ContextOptions& options);
  ~Context();
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  const DeviceInfo& info() const { return info_; }
  const VkPhysicalDeviceLimits& limits() const { return limits_; }
  const ContextOptions& options() const { return options_; }
  /// Whether the device was opened for ray queries.
  const VkPhysicalDeviceAccelerationStructurePropertiesKHR& structure_limits() const { return structure_limits_; }
  /// Bytes of the largest single allocation.
  std::uint64_t max_allocation() const { return max_allocation_; }
  /// Device memory available to this process, and the source of that number: the driver's budget (VK_EXT_memory_budget)
  /// if there is one, but never more than the largest device-local heap.
  struct AvailableMemory {
    std::uint64_t bytes = 0;
    const char* name = "";
  };
  AvailableMemory available_memory() const;
  bool is_cpu() const { return is_cpu_; }
  /// Memory of the program that begins at such a multiple of bytes can be that of a buffer: on CPUs, whose drivers read
  /// it where it is (VK_EXT_external_memory_host). 0 where it can't.
  std::uint64_t host_memory_alignment() const { return host_memory_alignment_; }
  VkDevice device() const { return device_; }
  VkQueue queue() const { return queue_; }
  std::uint32_t queue_family() const { return queue_family_; }
  VkPipelineCache pipeline_cache() const { return pipeline_cache_.get(); }
  const ModuleCache& modules() const { return modules_; }
  /// One sentence: which device was taken and why.
  const std::string& choice() const { return choice_; }
  /// Index of a memory type allowed by `type_bits` with all of `required`, preferring `preferred`; throws
  /// Error(lost) if there is none.
  std::uint32_t memory_type(std::uint32_t type_bits, VkMemoryPropertyFlags required,
                            VkMemoryPropertyFlags preferred) const;

 private:
  void open_device();
  void refuse_small_files() const;
  void read_limits();
  std::filesystem::path modules_folder() const;
  void load_pipeline_cache();
  void save_pipeline_cache() const;
  bool uses_cache_files() const { return options_.pipeline_cache && !options_.kernel_statistics; }

  ContextOptions options_;
  std::shared_ptr<Instance> instance_;
  DeviceInfo info_;
  std::string choice_;
  VkPhysicalDevice physical_ = VK_NULL_HANDLE;
  VkPhysicalDeviceLimits limits_{};
  VkPhysicalDeviceAccelerationStructurePropertiesKHR structure_limits_{};
  VkPhysicalDeviceMemoryProperties memory_{};
  std::uint64_t max_allocation_ = 0;
  std::uint64_t host_memory_alignment_ = 0;
  bool is_cpu_ = false;
  bool owned_ = true;
  VkDevice device_ = VK_NULL_HANDLE;
  VkQueue queue_ = VK_NULL_HANDLE;
  std::uint32_t queue_family_ = 0;
  Handle<VkPipelineCache, &vkDestroyPipelineCache> pipeline_cache_;
  ModuleCache modules_{modules_folder()};
};

/// Validation messages seen by this process (warnings and errors).
std::uint64_t validation_message_count();

}  // namespace etendue::vulkan
