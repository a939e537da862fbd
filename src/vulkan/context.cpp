#define VOLK_IMPLEMENTATION
#include "vulkan/context.h"

#include <unistd.h>

#ifdef __linux__
#include <sys/resource.h>
#include <sys/uio.h>

#include <cerrno>
#endif

#include <algorithm>
#include <atomic>
#include <cctype>
#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <mutex>

#include <fmt/core.h>

#include "core/errors.h"
#include "core/log.h"
#include "vulkan/cache_files.h"
#include "vulkan/check.h"

namespace etendue::vulkan {
namespace {

std::atomic<std::uint64_t> g_validation_messages{0};

VKAPI_ATTR VkBool32 VKAPI_CALL on_validation_message(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                                     VkDebugUtilsMessageTypeFlagsEXT,
                                                     const VkDebugUtilsMessengerCallbackDataEXT* data, void*) {
  const bool serious = severity >= VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT;
  if (serious) {
    ++g_validation_messages;
    log::error(fmt::format("Vulkan validation: {}", data->pMessage));
  }
  return VK_FALSE;
}

const char* type_name(VkPhysicalDeviceType type) {
  switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
      return "discrete GPU";
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
      return "integrated GPU";
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
      return "virtual GPU";
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
      return "CPU";
    default:
      return "other";
  }
}

std::string lower(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

// Index of a queue family with compute, preferably without graphics; -1 if there is none.
int compute_family(VkPhysicalDevice device) {
  std::uint32_t count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(device, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(device, &count, families.data());
  int best = -1;
  for (int i = 0; i < static_cast<int>(count); ++i) {
    if ((families[i].queueFlags & VK_QUEUE_COMPUTE_BIT) == 0) continue;
    if (best < 0 || (families[i].queueFlags & VK_QUEUE_GRAPHICS_BIT) == 0) best = i;
  }
  return best;
}

bool has_extension(VkPhysicalDevice device, const char* name) {
  std::uint32_t count = 0;
  if (vkEnumerateDeviceExtensionProperties(device, nullptr, &count, nullptr) != VK_SUCCESS) return false;
  std::vector<VkExtensionProperties> extensions(count);
  if (vkEnumerateDeviceExtensionProperties(device, nullptr, &count, extensions.data()) != VK_SUCCESS) return false;
  return std::ranges::any_of(extensions,
                             [&](const VkExtensionProperties& e) { return std::string_view(e.extensionName) == name; });
}

// At multiples of so many bytes the program's own memory can be that of a buffer which kernels read; 0: nowhere.
std::uint64_t importable_alignment(VkPhysicalDevice device) {
  if (!has_extension(device, VK_EXT_EXTERNAL_MEMORY_HOST_EXTENSION_NAME)) return 0;
  for (const VkBufferUsageFlags usage :
       {VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT}) {
    const VkPhysicalDeviceExternalBufferInfo buffer{
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_EXTERNAL_BUFFER_INFO,
        .usage = usage | VK_BUFFER_USAGE_TRANSFER_SRC_BIT,
        .handleType = VK_EXTERNAL_MEMORY_HANDLE_TYPE_HOST_ALLOCATION_BIT_EXT};
    VkExternalBufferProperties found{.sType = VK_STRUCTURE_TYPE_EXTERNAL_BUFFER_PROPERTIES};
    vkGetPhysicalDeviceExternalBufferProperties(device, &buffer, &found);
    if ((found.externalMemoryProperties.externalMemoryFeatures & VK_EXTERNAL_MEMORY_FEATURE_IMPORTABLE_BIT) == 0)
      return 0;
  }
  VkPhysicalDeviceExternalMemoryHostPropertiesEXT host{
      .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_EXTERNAL_MEMORY_HOST_PROPERTIES_EXT};
  VkPhysicalDeviceProperties2 properties{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, .pNext = &host};
  vkGetPhysicalDeviceProperties2(device, &properties);
  return host.minImportedHostPointerAlignment;
}

constexpr const char* kRayQueryExtensions[] = {VK_KHR_RAY_QUERY_EXTENSION_NAME,
                                               VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
                                               VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME};

// The feature structures needed for ray queries, chained for vkCreateDevice and for querying a device's features.
struct RayQueryFeatures {
  VkPhysicalDeviceBufferDeviceAddressFeatures addresses{
      .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_BUFFER_DEVICE_ADDRESS_FEATURES};
  VkPhysicalDeviceAccelerationStructureFeaturesKHR structures{
      .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR, .pNext = &addresses};
  VkPhysicalDeviceRayQueryFeaturesKHR queries{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_QUERY_FEATURES_KHR,
                                              .pNext = &structures};
  RayQueryFeatures() = default;
  RayQueryFeatures(const RayQueryFeatures&) = delete;
  RayQueryFeatures& operator=(const RayQueryFeatures&) = delete;
};

// The first thing that a device with Vulkan 1.2 lacks for ray queries; empty if they work.
std::string missing_for_ray_queries(VkPhysicalDevice device) {
  for (const char* name : kRayQueryExtensions)
    if (!has_extension(device, name)) return fmt::format("the extension {}", name);
  RayQueryFeatures has;
  VkPhysicalDeviceFeatures2 features{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, .pNext = &has.queries};
  vkGetPhysicalDeviceFeatures2(device, &features);
  if (has.addresses.bufferDeviceAddress == VK_FALSE) return "the feature bufferDeviceAddress";
  if (has.structures.accelerationStructure == VK_FALSE) return "the feature accelerationStructure";
  if (has.queries.rayQuery == VK_FALSE) return "the feature rayQuery";
  return "";
}

std::string missing_features(VkPhysicalDevice device, const VkPhysicalDeviceProperties& p,
                             const Requirements& requirements) {
  if (p.apiVersion < VK_API_VERSION_1_2) {
    return fmt::format("it speaks Vulkan {}.{}, 1.2 is needed", VK_API_VERSION_MAJOR(p.apiVersion),
                       VK_API_VERSION_MINOR(p.apiVersion));
  }
  if (compute_family(device) < 0) return "it has no compute queue";
  if (requirements.ray_queries) {
    if (const std::string lacks = missing_for_ray_queries(device); !lacks.empty())
      return fmt::format("it lacks {}, which '--traversal query' needs; '--traversal tree' does without", lacks);
  }
  return requirements.missing(p.limits);
}

DeviceInfo describe(VkPhysicalDevice device, std::uint32_t index, const Requirements& requirements) {
  VkPhysicalDeviceDriverProperties driver{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
  VkPhysicalDeviceSubgroupProperties subgroup{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES,
                                              .pNext = &driver};
  VkPhysicalDeviceProperties2 properties{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, .pNext = &subgroup};
  vkGetPhysicalDeviceProperties(device, &properties.properties);
  const VkPhysicalDeviceProperties basic = properties.properties;
  DeviceInfo info;
  info.index = index;
  info.name = basic.deviceName;
  info.type = type_name(basic.deviceType);
  info.api_version = basic.apiVersion;
  info.missing = missing_features(device, basic, requirements);
  VkDriverId driver_id{};  // stays unknown below Vulkan 1.2, where no device is usable
  if (basic.apiVersion >= VK_API_VERSION_1_2) {
    vkGetPhysicalDeviceProperties2(device, &properties);
    info.driver = driver.driverName;
    if (driver.driverInfo[0] != '\0') info.driver += fmt::format(" ({})", driver.driverInfo);
    driver_id = driver.driverID;
    info.subgroup_size = subgroup.subgroupSize;
    info.ray_queries = missing_for_ray_queries(device).empty();
    info.subgroup_ballot = (subgroup.supportedOperations & VK_SUBGROUP_FEATURE_BALLOT_BIT) != 0 &&
                           (subgroup.supportedStages & VK_SHADER_STAGE_COMPUTE_BIT) != 0;
  }
  info.rank = device_rank(basic.deviceType, driver_id);
  VkPhysicalDeviceMemoryProperties memory;
  vkGetPhysicalDeviceMemoryProperties(device, &memory);
  for (std::uint32_t i = 0; i < memory.memoryHeapCount; ++i) {
    if (memory.memoryHeaps[i].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT) {
      info.memory_bytes = std::max<std::uint64_t>(info.memory_bytes, memory.memoryHeaps[i].size);
    }
  }
  return info;
}

std::filesystem::path pipeline_cache_path(VkPhysicalDevice device) {
  const std::filesystem::path folder = cache_folder();
  if (folder.empty()) return {};
  VkPhysicalDeviceProperties p;
  vkGetPhysicalDeviceProperties(device, &p);
  std::string uuid;
  for (const std::uint8_t byte : p.pipelineCacheUUID) uuid += fmt::format("{:02x}", byte);
  return folder / fmt::format("pipelines-{:04x}-{:04x}-{}.bin", p.vendorID, p.deviceID, uuid);
}

}  // namespace

int device_rank(VkPhysicalDeviceType type, VkDriverId driver) {
  switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
      return 0;
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
      return 1;
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
      return 2;
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
      if (driver == VK_DRIVER_ID_MESA_LLVMPIPE) return 4;
      return driver == VK_DRIVER_ID_GOOGLE_SWIFTSHADER ? 6 : 5;
    default:  // another kind of accelerator, or a layer over another API: still hardware
      return 3;
  }
}

std::string Requirements::missing(const VkPhysicalDeviceLimits& limits) const {
  struct Limit {
    const char* name;
    const char* what;
    std::uint32_t has, needed;
  };
  const std::uint32_t lanes = std::min(limits.maxComputeWorkGroupInvocations, limits.maxComputeWorkGroupSize[0]);
  const std::uint32_t resources = storage_buffers + sampled_images + uniform_buffers;
  for (const Limit& limit : {
           Limit{"maxBoundDescriptorSets", "descriptor sets", limits.maxBoundDescriptorSets, sets},
           Limit{"maxPerStageDescriptorStorageBuffers", "storage buffers", limits.maxPerStageDescriptorStorageBuffers,
                 storage_buffers},
           Limit{"maxDescriptorSetStorageBuffers", "storage buffers in all sets", limits.maxDescriptorSetStorageBuffers,
                 storage_buffers},
           Limit{"maxPerStageDescriptorSampledImages", "texel buffers", limits.maxPerStageDescriptorSampledImages,
                 sampled_images},
           Limit{"maxDescriptorSetSampledImages", "texel buffers in all sets", limits.maxDescriptorSetSampledImages,
                 sampled_images},
           Limit{"maxPerStageDescriptorUniformBuffers", "uniform buffers", limits.maxPerStageDescriptorUniformBuffers,
                 uniform_buffers},
           Limit{"maxPerStageResources", "buffers of all kinds", limits.maxPerStageResources, resources},
           Limit{"maxPushConstantsSize", "bytes of push constants", limits.maxPushConstantsSize, push_constant_bytes},
           Limit{"maxUniformBufferRange", "bytes of a uniform buffer", limits.maxUniformBufferRange, uniform_bytes},
           Limit{"maxComputeWorkGroupInvocations", "lanes of a workgroup", lanes, workgroup_lanes},
       }) {
    if (limit.has < limit.needed)
      return fmt::format("it gives a kernel {} {} ({}), {} are needed", limit.has, limit.what, limit.name,
                         limit.needed);
  }
  return "";
}

/// The Vulkan instance with its debug messenger.
class Instance {
 public:
  explicit Instance(const ContextOptions& options) {
    static const VkResult loader = volkInitialize();
    if (loader != VK_SUCCESS) {
      throw Error(ErrorKind::device,
                  "No Vulkan loader (libvulkan.so.1) was found; install the packages libvulkan1 and "
                  "mesa-vulkan-drivers, or use --device reference.");
    }
    create(options);
    volkLoadInstance(instance_);
    if (options.validation) {
      const auto info = messenger_info();
      check(vkCreateDebugUtilsMessengerEXT(instance_, &info, nullptr, &messenger_), "listen to the validation layer");
    }
  }
  ~Instance() {
    if (left_open_) return;
    if (messenger_ != VK_NULL_HANDLE) vkDestroyDebugUtilsMessengerEXT(instance_, messenger_, nullptr);
    vkDestroyInstance(instance_, nullptr);
  }
  Instance(const Instance&) = delete;
  Instance& operator=(const Instance&) = delete;

  /// Leaves it to Vulkan until the end of the process: an instance must outlive its devices, and one of them stays
  /// open.
  void leave_open() { left_open_ = true; }

  std::vector<VkPhysicalDevice> physical_devices() const {
    std::uint32_t count = 0;
    check(vkEnumeratePhysicalDevices(instance_, &count, nullptr), "list the devices");
    std::vector<VkPhysicalDevice> devices(count);
    check(vkEnumeratePhysicalDevices(instance_, &count, devices.data()), "list the devices");
    devices.resize(count);
    return devices;
  }

 private:
  static VkDebugUtilsMessengerCreateInfoEXT messenger_info() {
    return {.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
            .messageSeverity =
                VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
            .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_GENERAL_BIT_EXT |
                           VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT |
                           VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT,
            .pfnUserCallback = on_validation_message};
  }

  void create(const ContextOptions& options) {
    const VkApplicationInfo application{
        .sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .pApplicationName = "etendue", .apiVersion = VK_API_VERSION_1_2};
    const VkValidationFeatureEnableEXT extra[] = {VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT,
                                                  VK_VALIDATION_FEATURE_ENABLE_GPU_ASSISTED_EXT};
    VkValidationFeaturesEXT features{.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT,
                                     .enabledValidationFeatureCount = options.validation_extra ? 2u : 0u,
                                     .pEnabledValidationFeatures = extra};
    const char* const layers[] = {"VK_LAYER_KHRONOS_validation"};
    const char* const extensions[] = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME};
    const VkInstanceCreateInfo info{.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                    .pNext = options.validation ? &features : nullptr,
                                    .pApplicationInfo = &application,
                                    .enabledLayerCount = options.validation ? 1u : 0u,
                                    .ppEnabledLayerNames = layers,
                                    .enabledExtensionCount = options.validation ? 1u : 0u,
                                    .ppEnabledExtensionNames = extensions};
    const VkResult result = vkCreateInstance(&info, nullptr, &instance_);
    if (result == VK_ERROR_LAYER_NOT_PRESENT) {
      throw Error(ErrorKind::device,
                  "The Khronos validation layer was requested but is not installed; install the package "
                  "vulkan-validationlayers.");
    }
    if (result == VK_ERROR_INCOMPATIBLE_DRIVER) {
      throw Error(ErrorKind::device,
                  "No Vulkan driver was found; install the package mesa-vulkan-drivers (its lavapipe needs no GPU), or "
                  "use --device reference.");
    }
    check(result, "start");
  }

  VkInstance instance_ = VK_NULL_HANDLE;
  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
  std::atomic<bool> left_open_{false};
};

namespace {

// All open devices share one instance: volk keeps its function pointers in globals, and a second instance would write
// them while other threads call through them. The last device to be closed destroys it under the same lock, so that
// creating and destroying an instance exclude each other.
std::shared_ptr<Instance> shared_instance(const ContextOptions& options) {
  static std::mutex mutex;
  static std::weak_ptr<Instance> current;
  static ContextOptions current_options;
  std::shared_ptr<Instance> open;  // declared before the lock, because destroying the last reference takes the lock
  const std::lock_guard lock(mutex);
  open = current.lock();
  if (open && options.validation == current_options.validation &&
      options.validation_extra == current_options.validation_extra)
    return open;
  const auto destroy = [](const Instance* instance) {
    const std::lock_guard lock_again(mutex);
    delete instance;
  };
  std::shared_ptr<Instance> fresh(new Instance(options), destroy);
  current = fresh;
  current_options = options;
  return fresh;
}

}  // namespace

ContextOptions ContextOptions::from_environment() {
  const char* value = std::getenv("ETENDUE_VALIDATION");
  const std::string_view text = value != nullptr ? value : "";
  return {.validation = text == "1" || text == "2", .validation_extra = text == "2"};
}

std::uint64_t validation_message_count() {
  return g_validation_messages;
}

std::vector<DeviceInfo> list_devices(const ContextOptions& options) {
  const auto instance = shared_instance(options);
  std::vector<DeviceInfo> infos;
  for (const VkPhysicalDevice device : instance->physical_devices()) {
    infos.push_back(describe(device, static_cast<std::uint32_t>(infos.size()), options.requirements));
  }
  return infos;
}

Context::Context(const std::string& selector, const ContextOptions& options)
    : options_(options), instance_(shared_instance(options)) {
  const std::vector<VkPhysicalDevice> devices = instance_->physical_devices();
  std::string others;
  int best_rank = 100;
  std::uint32_t wanted_index = 0;
  const auto [end, error] = std::from_chars(selector.data(), selector.data() + selector.size(), wanted_index);
  const bool by_index = error == std::errc{} && end == selector.data() + selector.size();
  for (std::uint32_t i = 0; i < devices.size(); ++i) {
    const DeviceInfo info = describe(devices[i], i, options.requirements);
    VkPhysicalDeviceProperties p;
    vkGetPhysicalDeviceProperties(devices[i], &p);
    const bool asked = selector == "auto" ||
                       (by_index ? i == wanted_index : lower(info.name).find(lower(selector)) != std::string::npos);
    std::string reason;
    if (!info.missing.empty()) {
      reason = info.missing;
    } else if (!asked) {
      reason = fmt::format("'--device {}' does not name it", selector);
    } else if (info.rank >= best_rank) {
      reason = fmt::format("'{}' comes first", info_.name);
    }
    if (reason.empty()) {
      if (physical_ != VK_NULL_HANDLE)
        others += fmt::format("; not {} '{}': '{}' ({}) is preferred", info_.index, info_.name, info.name, info.type);
      best_rank = info.rank;
      physical_ = devices[i];
      info_ = info;
      is_cpu_ = p.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
      limits_ = p.limits;
    } else {
      others += fmt::format("; not {} '{}': {}", i, info.name, reason);
    }
  }
  if (physical_ == VK_NULL_HANDLE) {
    throw Error(
        ErrorKind::device,
        fmt::format(
            "No suitable Vulkan device for '--device {}' among {}{}; see 'etendue devices', or use --device reference.",
            selector, devices.size(), others));
  }
  choice_ = fmt::format("Device {} '{}' ({}, {}){}.", info_.index, info_.name, info_.type, info_.driver, others);
  open_device();
  load_pipeline_cache();
}

Context::Context(const ForeignDevice& foreign, const ContextOptions& options)
    : options_(options),
      instance_(shared_instance(options)),
      info_(describe(foreign.physical, 0, options.requirements)),
      physical_(foreign.physical),
      owned_(false),
      device_(foreign.device),
      queue_(foreign.queue),
      queue_family_(foreign.queue_family) {
  if (!info_.missing.empty())
    throw Error(ErrorKind::device, fmt::format("The device '{}' cannot be used: {}.", info_.name, info_.missing));
  if (options.requirements.ray_queries && !foreign.ray_queries)
    throw Error(ErrorKind::device, fmt::format("The device '{}' was opened without ray queries, which '--traversal "
                                               "query' needs; open it with them, or use '--traversal tree'.",
                                               info_.name));
  VkPhysicalDeviceProperties p;
  vkGetPhysicalDeviceProperties(physical_, &p);
  is_cpu_ = p.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
  limits_ = p.limits;
  choice_ = fmt::format("Device '{}' ({}, {}), opened elsewhere.", info_.name, info_.type, info_.driver);
  read_limits();
  load_pipeline_cache();
}

Context::~Context() {
  if (is_abandoned(device_)) {
    instance_->leave_open();
    return;
  }
  save_pipeline_cache();
  pipeline_cache_ = {};
  if (owned_) vkDestroyDevice(device_, nullptr);
}

Context::AvailableMemory Context::available_memory() const {
  std::uint32_t largest = 0;
  for (std::uint32_t i = 0; i < memory_.memoryHeapCount; ++i) {
    const VkMemoryHeap &heap = memory_.memoryHeaps[i], &best = memory_.memoryHeaps[largest];
    const bool local = (heap.flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT) != 0;
    const bool best_local = (best.flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT) != 0;
    if (local != best_local ? local : heap.size > best.size) largest = i;
  }
  const std::uint64_t size = memory_.memoryHeaps[largest].size;
  if (!has_extension(physical_, VK_EXT_MEMORY_BUDGET_EXTENSION_NAME)) return {size, "size of its memory heap"};
  VkPhysicalDeviceMemoryBudgetPropertiesEXT budget{.sType =
                                                       VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MEMORY_BUDGET_PROPERTIES_EXT};
  VkPhysicalDeviceMemoryProperties2 memory{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MEMORY_PROPERTIES_2,
                                           .pNext = &budget};
  vkGetPhysicalDeviceMemoryProperties2(physical_, &memory);
  const std::uint64_t free =
      budget.heapBudget[largest] - std::min(budget.heapUsage[largest], budget.heapBudget[largest]);
  if (free < size) return {free, "what VK_EXT_memory_budget leaves of its memory heap"};
  return {size, "size of its memory heap"};
}

void Context::read_limits() {
  vkGetPhysicalDeviceMemoryProperties(physical_, &memory_);
  VkPhysicalDeviceMaintenance3Properties maintenance{.sType =
                                                         VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES};
  VkPhysicalDeviceProperties2 properties{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2,
                                         .pNext = &maintenance};
  vkGetPhysicalDeviceProperties2(physical_, &properties);
  max_allocation_ = maintenance.maxMemoryAllocationSize;
  if (!options_.requirements.ray_queries) return;
  structure_limits_ = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_PROPERTIES_KHR};
  properties.pNext = &structure_limits_;
  vkGetPhysicalDeviceProperties2(physical_, &properties);
  structure_limits_.pNext = nullptr;
}

// A CPU driver may keep device memory in an unnamed file (Mesa 25 does), to which the limit on file sizes applies. The
// driver does not check that its file has grown, and the first access beyond its end would kill the process with
// SIGBUS. So if an allocation exceeds that limit, its end is read by a system call first, which merely fails. If files
// may have kEnough bytes, nothing is checked: the largest allocation of an ordinary render is far smaller.
void Context::refuse_small_files() const {
#ifdef __linux__
  constexpr VkDeviceSize kEnough = VkDeviceSize{1} << 30;
  rlimit files{};
  if (!is_cpu_ || getrlimit(RLIMIT_FSIZE, &files) != 0 || files.rlim_cur >= kEnough) return;
  const VkMemoryAllocateInfo info{
      .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
      .allocationSize = std::max<VkDeviceSize>(2 * files.rlim_cur, VkDeviceSize{16} << 20),
      .memoryTypeIndex = memory_type(~0u, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT)};
  VkDeviceMemory memory = VK_NULL_HANDLE;
  if (vkAllocateMemory(device_, &info, nullptr, &memory) != VK_SUCCESS) return;
  void* start = nullptr;
  bool missing = false;
  if (vkMapMemory(device_, memory, 0, VK_WHOLE_SIZE, 0, &start) == VK_SUCCESS) {
    char byte = 0;
    const iovec here{&byte, 1}, there{static_cast<char*>(start) + info.allocationSize - 1, 1};
    missing = process_vm_readv(getpid(), &here, 1, &there, 1, 0) < 0 && errno == EFAULT;
  }
  vkFreeMemory(device_, memory, nullptr);
  if (!missing) return;
  throw Error(
      ErrorKind::device,
      fmt::format("'{}' keeps its memory in files, and a file may have {} bytes here; raise the limit (ulimit -f) "
                  "to {} bytes, or use --device reference.",
                  info_.name, files.rlim_cur, kEnough));
#endif
}

void Context::open_device() {
  read_limits();
  const bool statistics = options_.kernel_statistics;
  if (statistics && !has_extension(physical_, VK_KHR_PIPELINE_EXECUTABLE_PROPERTIES_EXTENSION_NAME))
    throw Error(ErrorKind::device,
                fmt::format("The driver of '{}' does not tell what it makes of kernels: it lacks the extension {}.",
                            info_.name, VK_KHR_PIPELINE_EXECUTABLE_PROPERTIES_EXTENSION_NAME));
  queue_family_ = static_cast<std::uint32_t>(compute_family(physical_));
  const float priority = 1.0f;
  const VkDeviceQueueCreateInfo queue_info{.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                           .queueFamilyIndex = queue_family_,
                                           .queueCount = 1,
                                           .pQueuePriorities = &priority};
  // Every Vulkan device supports it: an index out of range would read zero or do nothing, instead of doing harm.
  const VkPhysicalDeviceFeatures features{.robustBufferAccess = VK_TRUE};
  RayQueryFeatures on;
  on.addresses.bufferDeviceAddress = on.structures.accelerationStructure = on.queries.rayQuery = VK_TRUE;
  const bool queries = options_.requirements.ray_queries;
  std::vector<const char*> extensions;
  if (queries) extensions.assign(std::begin(kRayQueryExtensions), std::end(kRayQueryExtensions));
  VkPhysicalDevicePipelineExecutablePropertiesFeaturesKHR executables{
      .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PIPELINE_EXECUTABLE_PROPERTIES_FEATURES_KHR,
      .pNext = queries ? &on.queries : nullptr,
      .pipelineExecutableInfo = VK_TRUE};
  if (statistics) extensions.push_back(VK_KHR_PIPELINE_EXECUTABLE_PROPERTIES_EXTENSION_NAME);
  if (is_cpu_) host_memory_alignment_ = importable_alignment(physical_);
  if (host_memory_alignment_ != 0) extensions.push_back(VK_EXT_EXTERNAL_MEMORY_HOST_EXTENSION_NAME);
  const VkDeviceCreateInfo info{.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                .pNext = statistics ? &executables : executables.pNext,
                                .queueCreateInfoCount = 1,
                                .pQueueCreateInfos = &queue_info,
                                .enabledExtensionCount = static_cast<std::uint32_t>(extensions.size()),
                                .ppEnabledExtensionNames = extensions.data(),
                                .pEnabledFeatures = &features};
  check(vkCreateDevice(physical_, &info, nullptr, &device_), fmt::format("open the device '{}'", info_.name));
  vkGetDeviceQueue(device_, queue_family_, 0, &queue_);
  try {
    refuse_small_files();
  } catch (...) {
    vkDestroyDevice(device_, nullptr);
    throw;
  }
}

std::uint32_t Context::memory_type(std::uint32_t type_bits, VkMemoryPropertyFlags required,
                                   VkMemoryPropertyFlags preferred) const {
  for (const VkMemoryPropertyFlags wanted : {required | preferred, required}) {
    for (std::uint32_t i = 0; i < memory_.memoryTypeCount; ++i) {
      if ((type_bits >> i & 1u) != 0 && (memory_.memoryTypes[i].propertyFlags & wanted) == wanted) return i;
    }
  }
  throw Error(ErrorKind::lost,
              fmt::format("The device '{}' has no memory type with the properties {:#x}.", info_.name, required));
}

std::filesystem::path Context::modules_folder() const {
  return uses_cache_files() && !cache_folder().empty() ? cache_folder() / "modules" : std::filesystem::path();
}

void Context::load_pipeline_cache() {
  std::string bytes;
  if (const auto path = pipeline_cache_path(physical_); uses_cache_files() && !path.empty()) bytes = read_cached(path);
  VkPipelineCacheCreateInfo info{.sType = VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO,
                                 .initialDataSize = bytes.size(),
                                 .pInitialData = bytes.data()};
  VkPipelineCache cache = VK_NULL_HANDLE;
  if (vkCreatePipelineCache(device_, &info, nullptr, &cache) != VK_SUCCESS) {
    info.initialDataSize = 0;
    check(vkCreatePipelineCache(device_, &info, nullptr, &cache), "create a pipeline cache");
  }
  pipeline_cache_ = {device_, cache};
}

void Context::save_pipeline_cache() const {
  const auto path = pipeline_cache_path(physical_);
  std::size_t size = 0;
  if (!uses_cache_files() || path.empty() ||
      vkGetPipelineCacheData(device_, pipeline_cache_.get(), &size, nullptr) != VK_SUCCESS)
    return;
  std::string bytes(size, '\0');
  if (vkGetPipelineCacheData(device_, pipeline_cache_.get(), &size, bytes.data()) != VK_SUCCESS) return;
  bytes.resize(size);
  std::error_code ignored;
  if (std::filesystem::file_size(path, ignored) == size) return;
  write_cached(path, bytes);
}

}  // namespace etendue::vulkan
