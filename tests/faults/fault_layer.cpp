/// A Vulkan layer that makes a healthy device fail, for tests. The environment says how:
/// - ETENDUE_FAULT=lost: a dispatch returns VK_ERROR_DEVICE_LOST, and so does whatever its device is given later.
/// - ETENDUE_FAULT=hang: a dispatch never reaches the driver, its fence is never signalled, and to close its device
/// takes for ever.
/// - ETENDUE_FAULT=memory: an allocation returns VK_ERROR_OUT_OF_DEVICE_MEMORY.
/// - ETENDUE_FAULT=limits: the device says it can take less: ETENDUE_FAULT_TEXELS, ETENDUE_FAULT_RANGE,
/// ETENDUE_FAULT_HEAP and ETENDUE_FAULT_ALLOCATION lower maxTexelBufferElements, maxStorageBufferRange, the size of its
/// memory heaps and maxMemoryAllocationSize; ETENDUE_FAULT_BUFFERS and ETENDUE_FAULT_IMAGES the storage buffers and
/// sampled images that a kernel can be given; ETENDUE_FAULT_GROUPS the workgroups of a dispatch, and one of more ends
/// the process.
/// - ETENDUE_FAULT=minimum: every limit that a kernel can meet is the least that Vulkan guarantees.
/// - ETENDUE_FAULT=lacks: the device lacks ETENDUE_FAULT_LACKS, the name of a limit, which is then 0, of an extension
/// or a feature, or "Vulkan 1.2", "compute" or "ballot".
/// - ETENDUE_FAULT=slow: a dispatch that traces takes ETENDUE_FAULT_PATH nanoseconds longer for each of its paths, and
/// ETENDUE_FAULT_DEAR times that for the groups of film slots from ETENDUE_FAULT_FROM up to ETENDUE_FAULT_TO. Each adds
/// a line to the file ETENDUE_FAULT_LOG: its first group, groups, paths of each slot, and these nanoseconds.
/// - ETENDUE_FAULT_AFTER=N: the first N dispatches or allocations of the process are good.
/// - ETENDUE_FAULT_TIMES=N: faults in all; unlimited by default.

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <vulkan/vk_layer.h>
#include <vulkan/vulkan.h>

#include "gpu_types.h"

#define LAYER_EXPORT extern "C" __attribute__((visibility("default")))

namespace {

struct InstanceTable {
  PFN_vkGetInstanceProcAddr get = nullptr;
  PFN_vkDestroyInstance destroy = nullptr;
  PFN_vkGetPhysicalDeviceProperties properties = nullptr;
  PFN_vkGetPhysicalDeviceProperties2 properties2 = nullptr;
  PFN_vkGetPhysicalDeviceMemoryProperties memory = nullptr;
  PFN_vkGetPhysicalDeviceQueueFamilyProperties queues = nullptr;
  PFN_vkGetPhysicalDeviceFeatures2 features2 = nullptr;
  PFN_vkEnumerateDeviceExtensionProperties extensions = nullptr;
};
struct DeviceTable {
  PFN_vkGetDeviceProcAddr get = nullptr;
  PFN_vkDestroyDevice destroy = nullptr;
  PFN_vkQueueSubmit submit = nullptr;
  PFN_vkWaitForFences wait = nullptr;
  PFN_vkAllocateMemory allocate = nullptr;
  PFN_vkCmdDispatch dispatch = nullptr;
  PFN_vkCmdPushConstants push = nullptr;
  etendue::gpu::Pass pass{};   // pushed last
  std::uint64_t recorded = 0;  // nanoseconds that the recorded dispatches take longer
  std::uint64_t running = 0;   // and the submitted ones
  bool dispatch_recorded = false;
  bool lost = false;
  bool hung = false;
};

std::mutex g_mutex;
// By the loader's dispatch pointer, which a device shares with its queues and command buffers.
std::map<void*, InstanceTable> g_instances;
std::map<void*, DeviceTable> g_devices;
long g_count = 0;
long g_faults = 0;

template <typename T>
void* key(T handle) {
  return *reinterpret_cast<void**>(handle);
}

std::string fault() {
  const char* value = std::getenv("ETENDUE_FAULT");
  return value != nullptr ? value : "";
}
long number(const char* name, long otherwise) {
  const char* value = std::getenv(name);
  return value != nullptr ? std::atol(value) : otherwise;
}

// Counts one event; true when it is to fail. Call with the lock held.
bool fails_now() {
  if (++g_count <= number("ETENDUE_FAULT_AFTER", 0)) return false;
  if (g_faults >= number("ETENDUE_FAULT_TIMES", 1L << 30)) return false;
  ++g_faults;
  return true;
}

InstanceTable table_of(VkPhysicalDevice device) {
  const std::lock_guard lock(g_mutex);
  return g_instances.at(key(device));
}

// Lowers a limit to what the environment says.
template <typename T>
void lower(T& limit, const char* name) {
  if (fault() == "limits")
    limit = static_cast<T>(std::min<std::uint64_t>(limit, static_cast<std::uint64_t>(number(name, 1L << 62))));
}

bool lacks(const std::string& name) {
  const char* value = std::getenv("ETENDUE_FAULT_LACKS");
  return fault() == "lacks" && value != nullptr && name == value;
}

struct Guarantee {
  const char* name;
  std::uint32_t VkPhysicalDeviceLimits::*limit;
  std::uint32_t least;
};
constexpr Guarantee kGuarantees[] = {
    {"maxTexelBufferElements", &VkPhysicalDeviceLimits::maxTexelBufferElements, 65536},
    {"maxUniformBufferRange", &VkPhysicalDeviceLimits::maxUniformBufferRange, 16384},
    {"maxStorageBufferRange", &VkPhysicalDeviceLimits::maxStorageBufferRange, 1u << 27},
    {"maxPushConstantsSize", &VkPhysicalDeviceLimits::maxPushConstantsSize, 128},
    {"maxBoundDescriptorSets", &VkPhysicalDeviceLimits::maxBoundDescriptorSets, 4},
    {"maxPerStageDescriptorUniformBuffers", &VkPhysicalDeviceLimits::maxPerStageDescriptorUniformBuffers, 12},
    {"maxPerStageDescriptorStorageBuffers", &VkPhysicalDeviceLimits::maxPerStageDescriptorStorageBuffers, 4},
    {"maxPerStageDescriptorSampledImages", &VkPhysicalDeviceLimits::maxPerStageDescriptorSampledImages, 16},
    {"maxPerStageResources", &VkPhysicalDeviceLimits::maxPerStageResources, 128},
    {"maxDescriptorSetUniformBuffers", &VkPhysicalDeviceLimits::maxDescriptorSetUniformBuffers, 72},
    {"maxDescriptorSetStorageBuffers", &VkPhysicalDeviceLimits::maxDescriptorSetStorageBuffers, 24},
    {"maxDescriptorSetSampledImages", &VkPhysicalDeviceLimits::maxDescriptorSetSampledImages, 96},
    {"maxComputeSharedMemorySize", &VkPhysicalDeviceLimits::maxComputeSharedMemorySize, 16384},
    {"maxComputeWorkGroupInvocations", &VkPhysicalDeviceLimits::maxComputeWorkGroupInvocations, 128}};
constexpr std::uint32_t kLeastGroups = 65535, kLeastLanes[3] = {128, 128, 64};
constexpr std::uint64_t kLeastAllocation = 1u << 30;

void lower_limits(VkPhysicalDeviceLimits& limits) {
  for (const Guarantee& g : kGuarantees) {
    if (lacks(g.name)) limits.*g.limit = 0;
    if (fault() == "minimum") limits.*g.limit = std::min(limits.*g.limit, g.least);
  }
  for (int i = 0; i < 3 && fault() == "minimum"; ++i) {
    limits.maxComputeWorkGroupCount[i] = std::min(limits.maxComputeWorkGroupCount[i], kLeastGroups);
    limits.maxComputeWorkGroupSize[i] = std::min(limits.maxComputeWorkGroupSize[i], kLeastLanes[i]);
  }
  lower(limits.maxTexelBufferElements, "ETENDUE_FAULT_TEXELS");
  lower(limits.maxStorageBufferRange, "ETENDUE_FAULT_RANGE");
  lower(limits.maxPerStageDescriptorStorageBuffers, "ETENDUE_FAULT_BUFFERS");
  lower(limits.maxDescriptorSetStorageBuffers, "ETENDUE_FAULT_BUFFERS");
  lower(limits.maxPerStageDescriptorSampledImages, "ETENDUE_FAULT_IMAGES");
  lower(limits.maxDescriptorSetSampledImages, "ETENDUE_FAULT_IMAGES");
  lower(limits.maxComputeWorkGroupCount[0], "ETENDUE_FAULT_GROUPS");
}

VKAPI_ATTR void VKAPI_CALL get_properties(VkPhysicalDevice device, VkPhysicalDeviceProperties* properties) {
  table_of(device).properties(device, properties);
  lower_limits(properties->limits);
  if (lacks("Vulkan 1.2")) properties->apiVersion = VK_API_VERSION_1_1;
}

VKAPI_ATTR void VKAPI_CALL get_properties2(VkPhysicalDevice device, VkPhysicalDeviceProperties2* properties) {
  table_of(device).properties2(device, properties);
  lower_limits(properties->properties.limits);
  for (auto* next = static_cast<VkBaseOutStructure*>(properties->pNext); next != nullptr; next = next->pNext) {
    if (next->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES && lacks("ballot")) {
      reinterpret_cast<VkPhysicalDeviceSubgroupProperties*>(next)->supportedOperations &=
          ~static_cast<VkSubgroupFeatureFlags>(VK_SUBGROUP_FEATURE_BALLOT_BIT);
    }
    if (next->sType != VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES) continue;
    VkDeviceSize& most = reinterpret_cast<VkPhysicalDeviceMaintenance3Properties*>(next)->maxMemoryAllocationSize;
    lower(most, "ETENDUE_FAULT_ALLOCATION");
    if (fault() == "minimum") most = std::min(most, kLeastAllocation);
  }
}

VKAPI_ATTR void VKAPI_CALL get_queues(VkPhysicalDevice device, std::uint32_t* count,
                                      VkQueueFamilyProperties* families) {
  table_of(device).queues(device, count, families);
  for (std::uint32_t i = 0; families != nullptr && i < *count && lacks("compute"); ++i)
    families[i].queueFlags &= ~static_cast<VkQueueFlags>(VK_QUEUE_COMPUTE_BIT);
}

VKAPI_ATTR void VKAPI_CALL get_features2(VkPhysicalDevice device, VkPhysicalDeviceFeatures2* features) {
  table_of(device).features2(device, features);
  for (auto* next = static_cast<VkBaseOutStructure*>(features->pNext); next != nullptr; next = next->pNext) {
    if (next->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_BUFFER_DEVICE_ADDRESS_FEATURES && lacks("bufferDeviceAddress"))
      reinterpret_cast<VkPhysicalDeviceBufferDeviceAddressFeatures*>(next)->bufferDeviceAddress = VK_FALSE;
    if (next->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR &&
        lacks("accelerationStructure"))
      reinterpret_cast<VkPhysicalDeviceAccelerationStructureFeaturesKHR*>(next)->accelerationStructure = VK_FALSE;
    if (next->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_QUERY_FEATURES_KHR && lacks("rayQuery"))
      reinterpret_cast<VkPhysicalDeviceRayQueryFeaturesKHR*>(next)->rayQuery = VK_FALSE;
  }
}

VKAPI_ATTR VkResult VKAPI_CALL list_extensions(VkPhysicalDevice device, const char* layer, std::uint32_t* count,
                                               VkExtensionProperties* extensions) {
  if (layer != nullptr && std::strcmp(layer, "VK_LAYER_ETENDUE_fault") == 0) {
    *count = 0;
    return VK_SUCCESS;
  }
  const PFN_vkEnumerateDeviceExtensionProperties next = table_of(device).extensions;
  std::uint32_t all = 0;
  VkResult result = next(device, layer, &all, nullptr);
  std::vector<VkExtensionProperties> has(all);
  if (result == VK_SUCCESS) result = next(device, layer, &all, has.data());
  if (result != VK_SUCCESS) return result;
  std::erase_if(has, [](const VkExtensionProperties& e) { return lacks(e.extensionName); });
  if (extensions == nullptr) {
    *count = static_cast<std::uint32_t>(has.size());
    return VK_SUCCESS;
  }
  *count = std::min(*count, static_cast<std::uint32_t>(has.size()));
  std::copy_n(has.begin(), *count, extensions);
  return *count == has.size() ? VK_SUCCESS : VK_INCOMPLETE;
}

VKAPI_ATTR void VKAPI_CALL get_memory(VkPhysicalDevice device, VkPhysicalDeviceMemoryProperties* memory) {
  table_of(device).memory(device, memory);
  for (std::uint32_t i = 0; i < memory->memoryHeapCount; ++i) lower(memory->memoryHeaps[i].size, "ETENDUE_FAULT_HEAP");
}

// How much longer a pass takes on the slow device. Call with the lock held.
std::uint64_t delay(const etendue::gpu::Pass& pass) {
  // The other kernels have no budget; and what was left of a pass is counted with the pass.
  if (fault() != "slow" || pass.step_budget == 0 || pass.request_count > 0 || pass.resume != 0) return 0;
  const auto at = [](const char* name) { return static_cast<std::uint64_t>(number(name, 0)); };
  const std::uint64_t first = pass.first_group, end = first + pass.group_count;
  const std::uint64_t from = std::max(first, at("ETENDUE_FAULT_FROM")), to = std::min(end, at("ETENDUE_FAULT_TO"));
  const std::uint64_t dear = to > from ? to - from : 0;
  const std::uint64_t groups = pass.group_count - dear + dear * at("ETENDUE_FAULT_DEAR");
  const std::uint64_t paths = groups * pass.paths * etendue::gpu::kWorkgroupSize;
  const std::uint64_t nanoseconds = fails_now() ? paths * at("ETENDUE_FAULT_PATH") : 0;
  if (const char* log = std::getenv("ETENDUE_FAULT_LOG"))
    std::ofstream(log, std::ios::app) << first << ' ' << pass.group_count << ' ' << pass.paths << ' ' << nanoseconds
                                      << '\n';
  return nanoseconds;
}

VKAPI_ATTR VkResult VKAPI_CALL submit(VkQueue queue, std::uint32_t count, const VkSubmitInfo* infos, VkFence fence) {
  PFN_vkQueueSubmit next = nullptr;
  {
    const std::lock_guard lock(g_mutex);
    DeviceTable& device = g_devices.at(key(queue));
    const bool dispatches = std::exchange(device.dispatch_recorded, false);
    device.running += std::exchange(device.recorded, 0);
    if (device.lost) return VK_ERROR_DEVICE_LOST;
    if (dispatches && fault() == "lost" && fails_now()) {
      device.lost = true;
      return VK_ERROR_DEVICE_LOST;
    }
    if (dispatches && fault() == "hang" && fails_now()) device.hung = true;
    if (device.hung) return VK_SUCCESS;
    next = device.submit;
  }
  return next(queue, count, infos, fence);
}

VKAPI_ATTR VkResult VKAPI_CALL wait(VkDevice device, std::uint32_t count, const VkFence* fences, VkBool32 all,
                                    std::uint64_t timeout) {
  DeviceTable table;
  {
    const std::lock_guard lock(g_mutex);
    table = g_devices.at(key(device));
    g_devices.at(key(device)).running = 0;
  }
  if (table.lost) return VK_ERROR_DEVICE_LOST;
  if (table.hung) {
    std::this_thread::sleep_for(std::chrono::nanoseconds(timeout));
    return VK_TIMEOUT;
  }
  const VkResult result = table.wait(device, count, fences, all, timeout);
  std::this_thread::sleep_for(std::chrono::nanoseconds(table.running));
  return result;
}

VKAPI_ATTR VkResult VKAPI_CALL allocate(VkDevice device, const VkMemoryAllocateInfo* info,
                                        const VkAllocationCallbacks* callbacks, VkDeviceMemory* memory) {
  PFN_vkAllocateMemory next = nullptr;
  {
    const std::lock_guard lock(g_mutex);
    if (fault() == "memory" && fails_now()) return VK_ERROR_OUT_OF_DEVICE_MEMORY;
    next = g_devices.at(key(device)).allocate;
  }
  return next(device, info, callbacks, memory);
}

VKAPI_ATTR void VKAPI_CALL dispatch(VkCommandBuffer buffer, std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  std::uint32_t most = ~0u;
  lower(most, "ETENDUE_FAULT_GROUPS");
  if (fault() == "minimum") most = kLeastGroups;
  if (x > most) std::abort();
  PFN_vkCmdDispatch next = nullptr;
  {
    const std::lock_guard lock(g_mutex);
    DeviceTable& device = g_devices.at(key(buffer));
    device.dispatch_recorded = true;
    device.recorded += delay(device.pass);
    next = device.dispatch;
  }
  next(buffer, x, y, z);
}

VKAPI_ATTR void VKAPI_CALL push(VkCommandBuffer buffer, VkPipelineLayout layout, VkShaderStageFlags stages,
                                std::uint32_t offset, std::uint32_t size, const void* values) {
  PFN_vkCmdPushConstants next = nullptr;
  {
    const std::lock_guard lock(g_mutex);
    DeviceTable& device = g_devices.at(key(buffer));
    if (offset == 0 && size == sizeof device.pass) std::memcpy(&device.pass, values, size);
    next = device.push;
  }
  next(buffer, layout, stages, offset, size, values);
}

VKAPI_ATTR void VKAPI_CALL destroy_device(VkDevice device, const VkAllocationCallbacks* callbacks) {
  DeviceTable table;
  {
    const std::lock_guard lock(g_mutex);
    table = g_devices.at(key(device));
    if (!table.hung) g_devices.erase(key(device));
  }
  while (table.hung) pause();  // waits for work that never ends, as a driver does
  table.destroy(device, callbacks);
}

VKAPI_ATTR void VKAPI_CALL destroy_instance(VkInstance instance, const VkAllocationCallbacks* callbacks) {
  PFN_vkDestroyInstance next = nullptr;
  {
    const std::lock_guard lock(g_mutex);
    next = g_instances.at(key(instance)).destroy;
    g_instances.erase(key(instance));
  }
  next(instance, callbacks);
}

VKAPI_ATTR VkResult VKAPI_CALL create_instance(const VkInstanceCreateInfo* info, const VkAllocationCallbacks* callbacks,
                                               VkInstance* instance) {
  auto* link = static_cast<VkLayerInstanceCreateInfo*>(const_cast<void*>(info->pNext));
  while (link->sType != VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO || link->function != VK_LAYER_LINK_INFO) {
    link = static_cast<VkLayerInstanceCreateInfo*>(const_cast<void*>(link->pNext));
  }
  const PFN_vkGetInstanceProcAddr get = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
  link->u.pLayerInfo = link->u.pLayerInfo->pNext;
  const auto create = reinterpret_cast<PFN_vkCreateInstance>(get(VK_NULL_HANDLE, "vkCreateInstance"));
  const VkResult result = create(info, callbacks, instance);
  if (result != VK_SUCCESS) return result;
  const std::lock_guard lock(g_mutex);
  InstanceTable& table = g_instances[key(*instance)];
  table.get = get;
  table.destroy = reinterpret_cast<PFN_vkDestroyInstance>(get(*instance, "vkDestroyInstance"));
  table.properties =
      reinterpret_cast<PFN_vkGetPhysicalDeviceProperties>(get(*instance, "vkGetPhysicalDeviceProperties"));
  table.properties2 =
      reinterpret_cast<PFN_vkGetPhysicalDeviceProperties2>(get(*instance, "vkGetPhysicalDeviceProperties2"));
  table.memory =
      reinterpret_cast<PFN_vkGetPhysicalDeviceMemoryProperties>(get(*instance, "vkGetPhysicalDeviceMemoryProperties"));
  table.queues = reinterpret_cast<PFN_vkGetPhysicalDeviceQueueFamilyProperties>(
      get(*instance, "vkGetPhysicalDeviceQueueFamilyProperties"));
  table.features2 = reinterpret_cast<PFN_vkGetPhysicalDeviceFeatures2>(get(*instance, "vkGetPhysicalDeviceFeatures2"));
  table.extensions = reinterpret_cast<PFN_vkEnumerateDeviceExtensionProperties>(
      get(*instance, "vkEnumerateDeviceExtensionProperties"));
  return VK_SUCCESS;
}

VKAPI_ATTR VkResult VKAPI_CALL create_device(VkPhysicalDevice physical, const VkDeviceCreateInfo* info,
                                             const VkAllocationCallbacks* callbacks, VkDevice* device) {
  auto* link = static_cast<VkLayerDeviceCreateInfo*>(const_cast<void*>(info->pNext));
  while (link->sType != VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO || link->function != VK_LAYER_LINK_INFO) {
    link = static_cast<VkLayerDeviceCreateInfo*>(const_cast<void*>(link->pNext));
  }
  const PFN_vkGetInstanceProcAddr get_instance = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
  const PFN_vkGetDeviceProcAddr get = link->u.pLayerInfo->pfnNextGetDeviceProcAddr;
  link->u.pLayerInfo = link->u.pLayerInfo->pNext;
  const auto create = reinterpret_cast<PFN_vkCreateDevice>(get_instance(VK_NULL_HANDLE, "vkCreateDevice"));
  const VkResult result = create(physical, info, callbacks, device);
  if (result != VK_SUCCESS) return result;
  const std::lock_guard lock(g_mutex);
  DeviceTable& table = g_devices[key(*device)];
  table = {};
  table.get = get;
  table.destroy = reinterpret_cast<PFN_vkDestroyDevice>(get(*device, "vkDestroyDevice"));
  table.submit = reinterpret_cast<PFN_vkQueueSubmit>(get(*device, "vkQueueSubmit"));
  table.wait = reinterpret_cast<PFN_vkWaitForFences>(get(*device, "vkWaitForFences"));
  table.allocate = reinterpret_cast<PFN_vkAllocateMemory>(get(*device, "vkAllocateMemory"));
  table.dispatch = reinterpret_cast<PFN_vkCmdDispatch>(get(*device, "vkCmdDispatch"));
  table.push = reinterpret_cast<PFN_vkCmdPushConstants>(get(*device, "vkCmdPushConstants"));
  return VK_SUCCESS;
}

PFN_vkVoidFunction own(const char* name);

}  // namespace

LAYER_EXPORT VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL fault_GetDeviceProcAddr(VkDevice device, const char* name) {
  if (const PFN_vkVoidFunction function = own(name)) return function;
  const std::lock_guard lock(g_mutex);
  return g_devices.at(key(device)).get(device, name);
}

LAYER_EXPORT VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL fault_GetInstanceProcAddr(VkInstance instance, const char* name) {
  if (const PFN_vkVoidFunction function = own(name)) return function;
  if (instance == VK_NULL_HANDLE) return nullptr;
  PFN_vkGetInstanceProcAddr next = nullptr;
  {
    const std::lock_guard lock(g_mutex);
    next = g_instances.at(key(instance)).get;
  }
  return next(instance, name);
}

namespace {

PFN_vkVoidFunction own(const char* name) {
  static const std::map<std::string, PFN_vkVoidFunction> functions = {
      {"vkGetInstanceProcAddr", reinterpret_cast<PFN_vkVoidFunction>(fault_GetInstanceProcAddr)},
      {"vkGetDeviceProcAddr", reinterpret_cast<PFN_vkVoidFunction>(fault_GetDeviceProcAddr)},
      {"vkCreateInstance", reinterpret_cast<PFN_vkVoidFunction>(create_instance)},
      {"vkDestroyInstance", reinterpret_cast<PFN_vkVoidFunction>(destroy_instance)},
      {"vkGetPhysicalDeviceProperties", reinterpret_cast<PFN_vkVoidFunction>(get_properties)},
      {"vkGetPhysicalDeviceProperties2", reinterpret_cast<PFN_vkVoidFunction>(get_properties2)},
      {"vkGetPhysicalDeviceMemoryProperties", reinterpret_cast<PFN_vkVoidFunction>(get_memory)},
      {"vkGetPhysicalDeviceQueueFamilyProperties", reinterpret_cast<PFN_vkVoidFunction>(get_queues)},
      {"vkGetPhysicalDeviceFeatures2", reinterpret_cast<PFN_vkVoidFunction>(get_features2)},
      {"vkEnumerateDeviceExtensionProperties", reinterpret_cast<PFN_vkVoidFunction>(list_extensions)},
      {"vkCreateDevice", reinterpret_cast<PFN_vkVoidFunction>(create_device)},
      {"vkDestroyDevice", reinterpret_cast<PFN_vkVoidFunction>(destroy_device)},
      {"vkQueueSubmit", reinterpret_cast<PFN_vkVoidFunction>(submit)},
      {"vkWaitForFences", reinterpret_cast<PFN_vkVoidFunction>(wait)},
      {"vkAllocateMemory", reinterpret_cast<PFN_vkVoidFunction>(allocate)},
      {"vkCmdPushConstants", reinterpret_cast<PFN_vkVoidFunction>(push)},
      {"vkCmdDispatch", reinterpret_cast<PFN_vkVoidFunction>(dispatch)}};
  const auto found = functions.find(name);
  return found != functions.end() ? found->second : nullptr;
}

}  // namespace
